from __future__ import annotations

import pytest

from bt_mission.scenarios.coverage.places import CoveragePlace, places
from bt_mission.sessions.load import load
from tests.support.project import MISSIONS

ALWAYS = [
    "succeeded",
    "aborted",
    "rejected",
    "canceled by another client",
    "server not available",
    "no answer to the goal",
    "server lost",
]
CANCELS = ["succeeded late", "cancel refused", "unconfirmed"]


def there(tree: str, head: str = "") -> dict[str, CoveragePlace]:
    """The places of a mission, by their names."""
    mission = load(f"mission: m\n{head}\ntree:\n{tree}")
    return {place.name: place for _, _, place in places(mission)}


@pytest.mark.parametrize(
    ("modifiers", "more"),
    [
        ("", []),
        ("timeout: 5", ["canceled by timeout", *CANCELS]),
        ("cancel_when: remaining_angle < 5", ["canceled by condition", *CANCELS]),
        ("feedback_timeout: 2", ["feedback silent for too long", *CANCELS]),
    ],
)
def test_a_leaf_has_the_outcomes_that_its_limits_allow(modifiers, more):
    """What nobody asks for cannot happen."""
    (leaf,) = there(f"  turn: {{angle: 90}}\n  {modifiers}").values()
    assert sorted(leaf.outcomes) == sorted([*ALWAYS, *more])


@pytest.mark.parametrize(
    ("tree", "halted"),
    [
        ("  sequence: [turn: {angle: 1}, wait: 1]", False),
        ("  parallel: [turn: {angle: 1}, wait: 1]", False),
        ("  parallel: [turn: {angle: 1}, wait: 1]\n  succeed_when: any", True),
        ("  parallel: [turn: {angle: 1}, wait: 1]\n  succeed_when: any\n  rest: finish", False),
        ("  parallel: [turn: {angle: 1}, check: x > 0]", True),
        ("  timeout: 5\n  do: {turn: {angle: 1}}", True),
        ("  guard: x > 0\n  do: {repeat: {count: 2}, do: {turn: {angle: 1}}}", True),
        ("  guard: true\n  do: {turn: {angle: 1}}", False),
        ("  sequence: [check: x > 0, turn: {angle: 1}]\n  memory: false", True),
        ("  sequence: [turn: {angle: 1}, check: x > 0]\n  memory: false", False),
    ],
)
def test_a_leaf_is_halted_where_something_above_can_halt_it(tree, halted):
    """By a parallel, a limit, a guard, or a sequence that looks at the first again."""
    leaf = there(tree, "inputs: {x: 1}")["turn"]
    assert ("canceled by halt" in leaf.outcomes) is halted


def test_a_named_tree_is_halted_where_one_of_its_uses_is():
    """Through other trees, too; the place is in the tree, not at the use."""
    result = there(
        "  timeout: 5\n  do: {tree: outer}",
        "trees:\n  inner: {do: {turn: {angle: 1}}}\n  outer: {do: {tree: inner}}\n"
        "  other: {do: {spin: {target_yaw: 1}}}",
    )
    assert "canceled by halt" in result["turn"].outcomes
    assert result["turn"].tree == "inner"
    assert "canceled by halt" not in result["spin"].outcomes


@pytest.mark.parametrize(
    ("tree", "name", "outcomes", "branches"),
    [
        ("  sequence: [wait: 1, log: a]", "m", ["success"], []),
        ("  sequence: [check: x > 0, log: a]", "m", ["success", "failure"], []),
        ("  check: x > 0", "check x > 0", ["true", "false"], []),
        ("  check: true", "check true", ["true"], []),
        ("  fallback: [check: x > 0, log: a]", "m", ["success"], ["1 check x > 0", "2 log"]),
        ("  choose: [wait: 1, log: a]", "m", ["success"], ["1 wait", "2 log"]),
        ("  when: x > 0\n  do: {log: a}", "m", ["success"], ["true", "false"]),
        ("  when: true\n  do: {log: a}", "m", ["success"], ["true"]),
        ("  guard: x > 0\n  do: {wait: 1}", "m", ["success", "failure"], ["true", "false"]),
        ("  timeout: 3\n  do: {wait: 1}", "m", ["success", "expired"], []),
        ("  timeout: 3\n  do: {check: x > 0}", "m", ["success", "failure", "expired"], []),
        ("  for_each: {y: [1, 2]}\n  do: {log: $y}", "m", ["success"], []),
        ("  for_each: {y: $z}\n  do: {log: $y}", "m", ["success", "empty list"], []),
        ("  force: failure\n  do: {wait: 1}", "m", ["failure"], []),
        ("  tree: sure", "sure", ["success"], []),
    ],
)
def test_only_what_can_happen_is_asked_for(tree, name, outcomes, branches):
    """Each kind, with its outcomes and the ways that it can choose."""
    place = there(tree, "inputs: {x: 1, z: [1]}\ntrees: {sure: {do: {wait: 0.5}}}")[name]
    assert list(place.outcomes) == outcomes
    assert list(place.branches) == branches


@pytest.mark.parametrize("path", MISSIONS, ids=lambda path: path.name)
def test_no_two_nodes_stand_in_one_place(path):
    """So the place in the file can stand for the node."""
    results = [(document.file, place.key) for document, _, place in places(load(path))]
    assert len(set(results)) == len(results)
