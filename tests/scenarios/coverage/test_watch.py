"""What a run reaches; the servers are played, there is no ROS."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from bt_mission.scenarios.coverage.places import places
from bt_mission.scenarios.coverage.watch import CoverageWatch
from bt_mission.sessions.load import load
from tests.support.play import Play


class Seen:
    """A mission that is watched while it is played."""

    def __init__(self, play: Play, text: str) -> None:
        self.play = play
        mission = load(text)
        self._places = {id(step): place for _, step, place in places(mission)}
        CoverageWatch(mission, play.executive, self._places)

    @property
    def reached(self) -> list[str]:
        """Names of the nodes, in the order of the file."""
        return [place.name for place in self._places.values() if place.runs]

    def of(self, name: str) -> set[str]:
        """What came of a node, and which way it went."""
        (place,) = (known for known in self._places.values() if known.name == name)
        return {which for which, runs in (place.outcomes | place.branches).items() if runs}


@pytest.fixture
def watch(server) -> Callable[..., Seen]:
    """``watch(yaml_of_the_tree)``."""

    def start(tree: str, head: str = "") -> Seen:
        text = f"mission: m\ninputs: {{x: 1, z: []}}\n{head}\ntree:\n{tree}"
        return Seen(Play(text, type(server)), text)

    return start


def test_nodes_are_reached_when_a_tick_is_at_them(watch):
    """Those behind one that fails are not."""
    seen = watch("  sequence: [log: a, check: x > 1, wait: 1]")
    seen.play.tick()
    assert seen.reached == ["m", "log", "check x > 1"]


GUARDED = """\
  sequence:
    - set: {n: 0}
    - parallel:
        - guard: n < 1
          do: {DO}
          name: guarded
        - sequence: [wait: 0.1, set: {n: 1}]
"""
TWICE = """\
  sequence:
    - set: {n: 0}
    - repeat: {count: 2}
      do:
        sequence:
          - when: n > 0
            do: {log: a}
            name: fork
          - set: {n: n + 1}
"""


@pytest.mark.parametrize(
    ("tree", "seen"),
    [
        ("  sequence: [log: a, check: x > 1]", {"check x > 1": {"false"}, "m": {"failure"}}),
        (TWICE, {"fork": {"true", "false", "success"}}),
        (
            "  fallback: [check: x > 1, log: a, log: b]",
            {"m": {"1 check x > 1", "2 log", "success"}},
        ),
        ("  when: x > 1\n  do: {log: c}\n  else: {log: d}", {"m": {"false", "success"}}),
        (GUARDED.replace("DO", "wait: 5"), {"guarded": {"true", "false", "failure"}}),
        (GUARDED.replace("DO", "check: x > 1"), {"guarded": {"true", "failure"}}),
        ("  timeout: 0.1\n  do: {wait: 5}", {"m": {"expired"}}),
        ("  timeout: 0.1\n  do: {check: x > 1}", {"m": {"failure"}}),
        ("  for_each: {y: $z}\n  do: {log: $y}", {"m": {"empty list"}}),
        ("  for_each: {y: [7]}\n  do: {log: $y}", {"m": {"success"}}),
    ],
)
def test_what_came_of_a_node_is_seen(watch, tree, seen):
    """Of each way, also where the status is the same as before; two causes of a failure differ."""
    watched = watch(tree)
    watched.play.tick(5)
    assert {name: watched.of(name) for name in seen} == seen


def test_goals_end_in_one_of_the_closed_list(watch):
    """As the leaf saw it."""
    seen = watch("  retry: {attempts: 3}\n  do: {turn: {angle: 9}}")
    play = seen.play
    play.tick(2)
    play.turn.reject()
    play.tick(3)
    play.turn.accept()
    play.turn.abort()
    play.tick(3)
    play.turn.accept()
    play.turn.succeed()
    play.tick(2)
    assert play.status == "success"
    assert seen.of("turn") == {"rejected", "aborted", "succeeded"}


def test_a_goal_that_the_tree_halts(watch):
    """It is no end that the tick sees."""
    seen = watch("  timeout: 0.2\n  do: {turn: {angle: 9}}")
    seen.play.tick(2)
    seen.play.turn.accept()
    seen.play.tick(6)
    assert seen.of("turn") == {"canceled by halt"}


def test_a_goal_that_ends_with_the_test_was_not_halted(watch):
    """The tree has not asked for it."""
    seen = watch("  timeout: 20\n  do: {turn: {angle: 9}}")
    seen.play.tick(2)
    seen.play.executive.interrupt("the test is over")
    assert seen.of("turn") == set()


def test_each_use_of_a_named_tree_counts_where_it_is_written(watch):
    """Both in the place of the tree."""
    seen = watch(
        "  sequence:\n"
        "    - tree: {name: half, inputs: {y: 1}}\n      name: low\n"
        "    - tree: {name: half, inputs: {y: 3}}\n      name: high\n",
        "trees: {half: {needs: {y: number}, do: {fallback: [check: y > 2, log: $y]}}}",
    )
    seen.play.tick()
    assert seen.of("check y > 2") == {"true", "false"}
    assert seen.of("low") == seen.of("high") == {"success"}
