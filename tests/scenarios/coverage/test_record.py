"""What runs have reached: as a bitmap, as counts of files, in reports; there is no ROS."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from bt_mission.scenarios.coverage.places import CoveragePlace
from bt_mission.scenarios.coverage.record import CoverageRecord, CoverageTally, CoveredFile, Score
from bt_mission.sessions.load import load
from bt_mission.testing.coverage_report import as_html, as_text, in_ranges
from tests.support.play import Play
from tests.support.project import MISSIONS

TEXT = """\
mission: m
inputs: {x: 1}
trees: {half: {needs: {x: number}, do: {check: x > 1}}}
tree:
  fallback: [check: x > 1, log: a]
  name: way out
"""
PLACES = (
    "0 way out: reached",
    "0 way out: outcome success",
    "0 way out: branch 1 check x > 1",
    "0 way out: branch 2 log",
    "0.0 check x > 1: reached",
    "0.0 check x > 1: outcome true",
    "0.0 check x > 1: outcome false",
    "0.1 log: reached",
    "0.1 log: outcome success",
    "half:0 check x > 1: reached",
    "half:0 check x > 1: outcome true",
    "half:0 check x > 1: outcome false",
)


def record_of(text: str, server: object) -> CoverageRecord:
    """What a run of a few ticks reaches."""
    play = Play(text, type(server))
    record = CoverageRecord.attach(load(text), play.executive)
    play.tick(3)
    return record


def test_places_are_named_by_node_and_what_there_is_to_reach():
    """In the order of the file; those of a named tree with its name."""
    assert CoverageRecord.of(load(TEXT)).names == PLACES


def test_places_do_not_depend_on_inputs_and_seed():
    """So the records of a sweep over them can be united."""
    other = load(TEXT.replace("inputs: {x: 1}", "inputs: {x: 7}\nseed: 5"))
    assert CoverageRecord.of(other).names == PLACES


@pytest.mark.parametrize("path", MISSIONS, ids=lambda path: path.name)
def test_every_name_is_one_place(path):
    """As many as the table of ``--mission-cov`` counts."""
    record = CoverageRecord.of(load(path))
    score = Score.of(record.places)
    assert len(set(record.names)) == len(record.names)
    assert len(record.names) == score.nodes + score.outcomes + score.branches


def test_a_run_sets_what_it_reaches(server):
    """Each place once, in the order of all; the rest is missing."""
    record = record_of(TEXT, server)
    assert record.reached == (*PLACES[:5], PLACES[6], *PLACES[7:9])
    assert record.missing == (PLACES[5], *PLACES[9:])


def test_records_are_written_in_a_digit_for_four_places(server):
    """The first place is in the last digit."""
    assert record_of(TEXT, server).as_hex() == "1df"
    assert CoverageRecord.of(load(TEXT)).as_hex() == "000"
    assert CoverageRecord(()).as_hex() == ""


@pytest.mark.parametrize("text", ["", "1d", "01df", "g00", "fff0"])
def test_what_is_no_record_of_so_many_places_is_an_error(text):
    """A record of another mission is not taken for one of this."""
    with pytest.raises(ValueError, match=r"hexadecimal digits|invalid literal"):
        CoverageRecord.of(load(TEXT)).add(text)


def test_runs_add_up(server):
    """What is reached first is named once; counts are those of all runs."""
    all_runs = CoverageRecord.of(load(TEXT))
    low = record_of(TEXT, server)
    assert all_runs.add(low.as_hex(), 3) == low.reached
    assert all_runs.add(record_of(TEXT.replace("x: 1", "x: 2"), server).as_hex()) == (PLACES[5],)
    assert all_runs.missing == PLACES[9:]
    assert all_runs.places[0].marks == {
        "reached": 4,
        "outcome success": 4,
        "branch 1 check x > 1": 4,
        "branch 2 log": 3,
    }


# ---- files of several missions, tests and processes -----------------------------------------


def place(
    line: int, runs: int = 0, depth: int = 1, name: str = "turn", tree: str = "", /, **marks: int
) -> CoveragePlace:
    """A node in a line of its own; an outcome is ``outcome_x=1``."""
    counts = {mark.replace("_", " "): count for mark, count in marks.items()}
    path = ".".join("0" * (depth + 1))
    return CoveragePlace(tree, path, name, "action", line, 5, {"reached": runs, **counts})


def covered(*places: CoveragePlace, label: str = "a.yaml", mission: str = "a") -> CoveredFile:
    """A file with these nodes."""
    return CoveredFile(
        label, {mission}, ("mission: a",), {covered.key: covered for covered in places}
    )


def test_what_several_have_seen_adds_up_by_place():
    """Of one file, by whichever mission, in whichever process."""
    tally = CoverageTally()
    tally.add("a", covered(place(3, 1, outcome_success=1, outcome_failure=0)))
    more = covered(place(3, 2, outcome_success=0, outcome_failure=2), place(4), mission="b")
    tally.add("a", more)
    (result,) = tally.in_order()
    assert result.missions == {"a", "b"}
    assert [(item.line, item.runs) for item in result.in_order()] == [(3, 3), (4, 0)]
    assert result.in_order()[0].outcomes == {"success": 1, "failure": 2}


def test_what_a_use_makes_possible_is_asked_for_everywhere():
    """A tree that can be halted in one mission only."""
    result = covered(place(3, 1, outcome_succeeded=1))
    result.add(covered(place(3, 0, **{"outcome_succeeded": 0, "outcome_canceled by halt": 0})))
    assert result.in_order()[0].missing == ["canceled by halt"]


def test_the_score_counts_nodes_outcomes_and_branches():
    """All alike."""
    first = place(3, 2, outcome_success=2, outcome_failure=0, branch_a=1, branch_b=0)
    score = Score.of([first, place(4)])
    assert score == Score(nodes=2, reached=1, outcomes=2, seen=1, branches=2, taken=1)
    assert score.percent == 50.0
    assert Score().percent == 100.0


def test_it_is_sent_as_plain_data():
    """What another process takes in is the same, added once more."""
    tally = CoverageTally()
    tally.add("a", covered(place(3, 2, branch_true=1)))
    sent = json.loads(json.dumps(tally.data()))
    tally.take(sent)
    other = CoverageTally()
    other.take(sent)
    other.take(sent)
    assert tally == other
    assert tally.files["a"].in_order()[0].branches == {"true": 2}


def test_texts_of_one_name_are_numbered():
    """In the order of their keys, which every process knows alike."""
    tally = CoverageTally()
    tally.add("t 9", covered(place(3), label="t"))
    tally.add("t 1", covered(place(4), label="t"))
    tally.add("b", covered(label="b"))
    assert [item.label for item in tally.in_order()] == ["b", "t (1)", "t (2)"]
    assert [item.label for item in tally.in_order()] == ["b", "t (1)", "t (2)"]


def test_the_report_for_programs():
    """A score in all and of each file, and every node."""
    tally = CoverageTally()
    tally.add("a", covered(place(3, 1, outcome_succeeded=1, outcome_aborted=0)))
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


# ---- reports for people ---------------------------------------------------------------------

MANY = {f"outcome {end}": 0 for end in ("aborted", "rejected", "server lost", "no answer", "lost")}


@pytest.fixture
def tally() -> CoverageTally:
    """One file with a named tree."""
    file = covered(
        place(3, 1, 0, "look", "look", outcome_succeeded=1, **MANY),
        place(5, 1, 0, "tour", outcome_success=1, outcome_failure=0),
        place(6, 1, 1, "here", outcome_success=1),
        place(7, 1, 1, "either", **{"branch 1 a": 1, "branch 2 b": 0}),
        place(8, 1, 2, "a"),
        place(9, 0, 2, "b"),
        place(10, 0, 3, "<below>"),
    )
    file = replace(file, source=tuple(f"- line {number} <&>" for number in range(1, 12)))
    made = CoverageTally()
    made.add("a", file)
    return made


def lines_of(tally: CoverageTally, *, brief: bool = False) -> tuple[list[str], list[str]]:
    """The lines of the table, and those of the trees."""
    lines = list(as_text(tally, brief=brief))
    end = lines.index("") if "" in lines else len(lines)
    return lines[:end], lines[end:]


def test_the_table_has_a_line_for_each_file(tally):
    """And one for all where there are several."""
    tally.add("b", covered(place(1, 1, 0, "b"), label="much_longer.yaml"))
    assert lines_of(tally)[0] == [
        "missions          nodes  reached  outcomes  seen  branches  taken  cover  missing",
        "a.yaml                7        5         9     3         2      1    50%  9-10",
        "much_longer.yaml      1        1         0     0         0      0   100%",
        "in all                8        6         9     3         2      1    52%",
    ]


def test_the_tree_shows_what_was_not_reached_and_the_way_there(tally):
    """What lies below a node that was never reached is not told again."""
    assert lines_of(tally)[1] == [
        "",
        "a.yaml",
        "        tree look:",
        "     3  look      never: aborted, rejected, server lost, no answer, lost",
        "        the mission:",
        "     5  tour      never: failure",
        "     7    either  never: 2 b",
        "     9      b     never reached",
    ]


def test_a_long_list_is_told_by_what_was_seen(tally):
    """On the terminal."""
    assert "     3  look      only: succeeded (of 6 outcomes)" in lines_of(tally, brief=True)[1]


def test_a_file_that_is_reached_in_full_shows_no_tree():
    """There is nothing to say."""
    tally = CoverageTally()
    tally.add("b", covered(place(1, 1, 0, "b"), label="b.yaml"))
    assert lines_of(tally)[1] == []


def test_lines_between_which_no_node_stands_are_one_range(tally):
    """A comment does not part them, a node that was reached does."""
    (covered,) = tally.in_order()
    assert in_ranges([5, 6, 9, 10], covered) == "5-6, 9-10"
    assert in_ranges([10], covered) == "10"


def test_the_page_shows_the_lines_with_what_is_missing(tally):
    """Escaped, each with its colour."""
    text = as_html(tally)
    assert '<span class="all"><i>6</i>- line 6 &lt;&amp;&gt;</span>' in text
    assert '<span class="part"><i>7</i>- line 7 &lt;&amp;&gt;<b>never: 2 b</b></span>' in text
    assert '<span class="none"><i>10</i>- line 10 &lt;&amp;&gt;<b>never reached</b></span>' in text
    assert '<span class="text"><i>4</i>' in text
    assert "<h1>Coverage of missions: 50%</h1>" in text
