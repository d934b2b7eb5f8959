"""Behaviours of a user's own, in a mission."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

from bt_mission.behaviours import python_leaf
from bt_mission.core.errors import BtMissionError
from tests.support.project import ROOT

CODE = ROOT / "docs" / "tutorials" / "code"


@pytest.fixture(autouse=True)
def beside_the_code(monkeypatch: pytest.MonkeyPatch) -> None:
    """A text as a mission has no folder but the one we are in."""
    monkeypatch.chdir(CODE)


def test_inputs_are_set_at_each_entry_and_outputs_read_at_the_end(play: Any) -> None:
    """The loop hands another number over each time."""
    run = play(
        "  for_each: {n: [1, 2]}\n  do:\n    sequence:\n"
        "      - python: own_leaves.py:Countdown\n"
        "        inputs: {ticks: $n}\n        outputs: {said: last}\n"
        "      - log: $last"
    )
    assert run.tick() == "RSSS"
    assert run.tick() == "RRRI"
    assert run.tick() == "SSSS"
    assert run.logged == ["0 to go", "0 to go"]


def test_it_is_given_the_runtime(play: Any) -> None:
    """It reads the mission's clock, and keeps its own state from one entry to the next."""
    run = play(
        "  repeat: {count: 2}\n  do: {python: 'own_leaves.py:Slower', inputs: {seconds: 0.1}}"
    )
    assert run.tick(3) == "RS"
    assert run.tick(5) == "SS"
    assert run.logged == ["waited for 0.10 s", "waited for 0.20 s"]


def test_an_exception_halts_the_tree_and_cancels_every_goal(
    play: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The mission fails with the cause and its place; nothing goes on."""
    (tmp_path / "bad.py").write_text(
        "from py_trees.behaviour import Behaviour\n\n"
        "class Bad(Behaviour):\n    def update(self):\n        raise ValueError('no')\n"
    )
    monkeypatch.chdir(tmp_path)
    run = play(
        "  parallel:\n    - {turn: {angle: 90}, timeout: 9}\n"
        "    - sequence: [{wait: 0.05}, {python: 'bad.py:Bad'}]"
    )
    run.tick()
    run.turn.accept()
    run.tick()
    assert run.executive.reason == "<text>:5:32: 'Bad': ValueError: no (bad.py:5) [BT-913]"
    assert run.turn.cancels == [run.turn.goal]
    run.turn.cancel(None)
    run.tick()
    assert run.status == "failure"
    assert run.executive.goals_left_behind == ()


PAIR = """
from py_trees.behaviours import Success
from py_trees.composites import Sequence

class Pair(Sequence):
    said = "both"

    def __init__(self, name):
        super().__init__(name, True, [Success("one"), Success("two")])
"""


def test_a_behaviour_with_children_has_them_in_the_tree(
    play: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each is ticked and seen; a breakpoint is set before all of it, and not before a child."""
    (tmp_path / "pair.py").write_text(PAIR)
    monkeypatch.chdir(tmp_path)
    run = play("  sequence:\n    - {python: 'pair.py:Pair', outputs: {said: s}}\n    - log: $s")
    points = run.executive.breakpoints
    with pytest.raises(BtMissionError, match="'one' is inside a behaviour written in Python"):
        points.add("one")
    points.add("0.0")
    assert run.tick() == "IIIII"
    assert run.executive.paused == "breakpoint at 'Pair'"
    run.executive.resume()
    assert run.tick() == "SSSSS"
    assert run.logged == ["both"]
    assert sum('"path": "0.0.1"' in line for line in run.trace.newest) == 1


def test_what_a_behaviour_says_of_itself_is_read_through_its_leaf(
    play: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its own name, message and attributes, also those that no output names."""
    (tmp_path / "named.py").write_text(
        "from py_trees.behaviour import Behaviour\nfrom py_trees.common import Status\n\n"
        "class Named(Behaviour):\n    def __init__(self, name):\n"
        "        super().__init__('my own')\n        self.updates = 0\n"
        "    def update(self):\n        self.updates += 1\n"
        "        self.feedback_message = f'{self.updates} so far'\n"
        "        return Status.RUNNING\n"
    )
    monkeypatch.chdir(tmp_path)
    run = play("  python: named.py:Named")
    run.tick(3)
    leaf = run.executive.root
    assert (leaf.name, leaf.feedback_message, leaf.updates) == ("my own", "3 so far", 3)


def test_a_halt_reaches_its_terminate(
    play: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With INVALID, as py_trees has it; outputs are not read then."""
    (tmp_path / "halted.py").write_text(
        "from py_trees.behaviour import Behaviour\nfrom py_trees.common import Status\n\n"
        "class Halted(Behaviour):\n    seen: str = ''\n"
        "    def update(self):\n        return Status.RUNNING\n"
        "    def terminate(self, new_status):\n        type(self).seen = new_status.value\n"
    )
    monkeypatch.chdir(tmp_path)
    run = play(
        "  parallel:\n    - {python: 'halted.py:Halted', outputs: {seen: s}}\n    - wait: 0.05\n"
        "  succeed_when: any"
    )
    run.tick(2)
    (module,) = [first for name, first in sys.modules.items() if name.endswith("_halted")]
    assert module.Halted.seen == "INVALID"
    assert "s" not in run.scope.values


@pytest.mark.parametrize(
    ("returned", "message"),
    [
        ("'SUCCESS'", "returned string 'SUCCESS', expected Status.SUCCESS, Status.FAILURE or"),
        ("None", "returned nothing, expected"),
        ("True", "returned true, expected"),
        ("Status.INVALID", "expected Status.SUCCESS"),
    ],
)
def test_what_is_no_status_is_reported_with_its_file_and_line(
    play: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, returned: str, message: str
) -> None:
    """The mission fails, and says where and what to write."""
    (tmp_path / "words.py").write_text(
        "from py_trees.behaviour import Behaviour\nfrom py_trees.common import Status\n\n\n"
        f"class Words(Behaviour):\n    def update(self):\n        return {returned}\n"
    )
    monkeypatch.chdir(tmp_path)
    run = play("  python: 'words.py:Words'")
    run.tick()
    reason = run.executive.reason
    assert "Words.update() (words.py:6)" in reason
    assert message in reason
    assert ("; write Status.SUCCESS" in reason) is (returned == "'SUCCESS'")


def test_a_leaf_that_blocks_is_named_once_and_not_in_the_trace(
    play: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the wall, which says that each tick has taken so long."""

    class SlowWall:
        elapsed_s = 2.4

    monkeypatch.setattr(python_leaf, "Stopwatch", SlowWall)
    run = play("  python: own_leaves.py:Countdown\n  inputs: {ticks: 3}")
    run.tick(3)
    (warning,) = run.warned
    assert "(own_leaves.py:Countdown) blocked a tick for 2.4 s of wall time" in warning
    assert run.logged == []


def test_a_leaf_that_does_not_block_is_not_named(play: Any) -> None:
    """As most do not."""
    run = play("  python: own_leaves.py:Countdown\n  inputs: {ticks: 3}")
    run.tick(3)
    assert run.warned == []
