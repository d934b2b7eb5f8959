from __future__ import annotations

import json

from bt_mission.coverage.tally import Covered, Score, Spot, Tally


def spot(line: int, *, runs: int = 0, name: str = "turn", depth: int = 1, **more) -> Spot:
    """A node in a line of its own."""
    return Spot(line=line, column=5, kind="action", name=name, depth=depth, runs=runs, **more)


def covered(*spots: Spot, label: str = "a.yaml", mission: str = "a") -> Covered:
    """A file with these nodes."""
    return Covered(label, {mission}, ("mission: a",), {one.key: one for one in spots})


def test_what_several_have_seen_adds_up_by_place():
    """Of one file, by whichever mission, in whichever process."""
    tally = Tally()
    tally.add("a", covered(spot(3, runs=1, outcomes={"success": 1, "failure": 0})))
    more = covered(spot(3, runs=2, outcomes={"success": 0, "failure": 2}), spot(4), mission="b")
    tally.add("a", more)
    (found,) = tally.in_order()
    assert found.missions == {"a", "b"}
    assert [(one.line, one.runs) for one in found.in_order()] == [(3, 3), (4, 0)]
    assert found.in_order()[0].outcomes == {"success": 1, "failure": 2}


def test_what_a_use_makes_possible_is_asked_for_everywhere():
    """A tree that can be halted in one mission only."""
    first = spot(3, runs=1, outcomes={"succeeded": 1})
    first.add(spot(3, runs=0, outcomes={"succeeded": 0, "canceled by halt": 0}))
    assert first.missing == ["canceled by halt"]


def test_the_score_counts_nodes_outcomes_and_branches():
    """All alike."""
    spots = [
        spot(3, runs=2, outcomes={"success": 2, "failure": 0}, branches={"1 a": 1, "2 b": 0}),
        spot(4),
    ]
    score = Score.of(spots)
    assert score == Score(nodes=2, reached=1, outcomes=2, seen=1, branches=2, taken=1)
    assert score.percent == 50.0
    assert Score().percent == 100.0


def test_it_is_sent_as_plain_data():
    """What another process takes in is the same, added once more."""
    tally = Tally()
    tally.add("a", covered(spot(3, runs=2, branches={"true": 1})))
    sent = json.loads(json.dumps(tally.data()))
    tally.take(sent)
    other = Tally()
    other.take(sent)
    other.take(sent)
    assert tally == other
    assert tally.files["a"].in_order()[0].branches == {"true": 2}


def test_texts_of_one_name_are_numbered():
    """In the order of their keys, which every process knows alike."""
    tally = Tally()
    tally.add("t 9", covered(spot(3), label="t"))
    tally.add("t 1", covered(spot(4), label="t"))
    tally.add("b", covered(label="b"))
    assert [one.label for one in tally.in_order()] == ["b", "t (1)", "t (2)"]
    assert [one.label for one in tally.in_order()] == ["b", "t (1)", "t (2)"]


def test_the_report_for_programs():
    """A score in all and of each file, and every node."""
    tally = Tally()
    tally.add("a", covered(spot(3, runs=1, outcomes={"succeeded": 1, "aborted": 0})))
    assert tally.report() == {
        "version": 1,
        "total": (score := tally.report()["files"]["a.yaml"]["score"]),
        "files": {
            "a.yaml": {
                "missions": ["a"],
                "score": score,
                "nodes": [
                    {
                        "line": 3,
                        "column": 5,
                        "kind": "action",
                        "name": "turn",
                        "tree": "",
                        "depth": 1,
                        "runs": 1,
                        "outcomes": {"succeeded": 1, "aborted": 0},
                        "branches": {},
                    }
                ],
            }
        },
    }
    assert score["percent"] == 66.67
