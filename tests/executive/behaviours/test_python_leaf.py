"""Behaviours of a user's own, in a mission."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bt_mission.base.errors import BtMissionError
from bt_mission.executive.behaviours import python_leaf
from tests.support.project import ROOT

CODE = ROOT / "docs" / "tutorials" / "code"


@pytest.fixture(autouse=True)
def beside_the_code(monkeypatch: pytest.MonkeyPatch) -> None:
    """A text as a mission has no folder but the one we are in."""
    monkeypatch.chdir(CODE)


HEADER = """
from py_trees.behaviour import Behaviour
from py_trees.behaviours import Success
from py_trees.common import Status
from py_trees.composites import Sequence

"""


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Write `own.py` with behaviours, and work beside it."""

    def write_own(code: str) -> None:
        (tmp_path / "own.py").write_text(HEADER + code)
        monkeypatch.chdir(tmp_path)

    return write_own


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


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("    def __init__(self): ...\n    def update(self): ...\n", "2 were given (own.py:8)"),
        ("    pass\n", "with abstract method update (own.py:7)"),
    ],
)
def test_an_error_of_a_call_has_the_place_of_what_was_called(
    play: Any, write: Any, code: str, message: str
) -> None:
    """No line of the user has raised it."""
    write(f"class Mine(Behaviour):\n{code}")
    with pytest.raises(BtMissionError) as caught:
        play("  python: 'own.py:Mine'")
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("import nothing_there\n", "No module named 'nothing_there' (own.py:7)"),
        ("x = (\n", "SyntaxError: '(' was never closed (own.py:7)"),
    ],
)
def test_an_import_that_fails_has_its_place(play: Any, write: Any, code: str, message: str) -> None:
    """In the file of the user."""
    write(code)
    with pytest.raises(BtMissionError) as caught:
        play("  python: 'own.py:Mine'")
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("declared", "value", "got"),
    [
        ("count: int = 0", "'seven'", "expected an integer, got string 'seven'"),
        ("count: int = 0", "0.5", "expected an integer, got the number 0.5"),
        ("count: int = 0", "None", "expected an integer, got nothing"),
        ("count: float = 0", "float('nan')", "expected a number, got NaN"),
        ("count: bool = True", "1", "expected a boolean, got the number 1"),
        ("count = 0", "float('nan')", "expected a value, got NaN"),
        ("count: float = 0", "3", ""),
        ("count = 0", "'seven'", ""),
    ],
)
def test_an_output_has_the_declared_type(
    play: Any, write: Any, declared: str, value: str, got: str
) -> None:
    """As a result of an action has; the error has the place in the mission and in the code."""
    code = f"class Counts(Behaviour):\n    {declared}\n    def update(self):\n"
    write(f"{code}        self.count = {value}\n        return Status.SUCCESS\n")
    run = play("  python: 'own.py:Counts'\n  outputs: {count: n}")
    run.tick()
    place = "<text>:3:3: 'Counts': output 'count' of Counts (own.py:9): "
    assert run.executive.reason == (f"{place}{got} [BT-913]" if got else "")


def test_it_is_given_the_runtime(play: Any) -> None:
    """It reads the mission's clock, and keeps its own state from one entry to the next."""
    run = play(
        "  repeat: {count: 2}\n  do: {python: 'own_leaves.py:Slower', inputs: {seconds: 0.1}}"
    )
    assert run.tick(3) == "RS"
    assert run.tick(5) == "SS"
    assert run.logged == ["waited for 0.10 s", "waited for 0.20 s"]


def test_an_exception_halts_the_tree_and_cancels_every_goal(play: Any, write: Any) -> None:
    """The mission fails with the cause and its place; nothing goes on."""
    write("class Bad(Behaviour):\n    def update(self):\n        raise ValueError('no')\n")
    run = play(
        "  parallel:\n    - {turn: {angle: 90}, timeout: 9}\n"
        "    - sequence: [{wait: 0.05}, {python: 'own.py:Bad'}]"
    )
    run.tick()
    run.turn.accept()
    run.tick()
    assert run.executive.reason == "<text>:5:32: 'Bad': ValueError: no (own.py:9) [BT-913]"
    assert run.turn.cancels == [run.turn.goal]
    run.turn.cancel(None)
    run.tick()
    assert run.status == "failure"
    assert run.executive.goals_left_behind == ()


PAIR = """
class Pair(Sequence):
    said = "both"
    def __init__(self, name):
        super().__init__(name, True, [Success("one"), Success("two")])
"""


def test_a_behaviour_with_children_has_them_in_the_tree(play: Any, write: Any) -> None:
    """Each is ticked and seen; a breakpoint is set before all of it, and not before a child."""
    write(PAIR)
    run = play("  sequence:\n    - {python: 'own.py:Pair', outputs: {said: s}}\n    - log: $s")
    points = run.executive.breakpoints
    with pytest.raises(BtMissionError, match="'one' is inside a behaviour written in Python"):
        points.add("one")
    points.add("0.0")
    assert run.tick() == "IIIII"
    assert run.executive.reason == "breakpoint at 'Pair'"
    run.executive.resume()
    assert run.tick() == "SSSSS"
    assert run.logged == ["both"]
    assert sum('"path": "0.0.1"' in line for line in run.trace.newest) == 1


NAMED = """
class Named(Behaviour):
    def __init__(self, name):
        super().__init__("my own")
        self.updates = 0
    def update(self):
        self.updates += 1
        self.feedback_message = f"{self.updates} so far"
        return Status.RUNNING
"""


def test_what_a_behaviour_says_of_itself_is_read_through_its_leaf(play: Any, write: Any) -> None:
    """Its own name, message and attributes, also those that no output names."""
    write(NAMED)
    run = play("  python: own.py:Named")
    run.tick(3)
    leaf = run.executive.root
    assert (leaf.name, leaf.feedback_message, leaf.updates) == ("my own", "3 so far", 3)


HALTED = """
class Halted(Behaviour):
    seen: str = ""
    def update(self):
        return Status.RUNNING
    def terminate(self, new_status):
        type(self).seen = new_status.value
"""


def test_a_halt_reaches_its_terminate(play: Any, write: Any) -> None:
    """With INVALID, as py_trees has it; outputs are not read then."""
    write(HALTED)
    run = play(
        "  parallel:\n    - {python: 'own.py:Halted', outputs: {seen: s}}\n    - wait: 0.05\n"
        "  succeed_when: any"
    )
    leaf = run.root.children[0]
    run.tick(2)
    assert leaf.seen == "INVALID"
    assert "s" not in run.scope.values


@pytest.mark.parametrize(
    ("returned", "message"),
    [
        ("'SUCCESS'", "returned string 'SUCCESS', expected Status.SUCCESS, Status.FAILURE or"),
        ("None", "returned nothing, expected"),
        ("True", "returned true, expected"),
        ("Status.INVALID", "returned Status.INVALID, expected Status.SUCCESS"),
    ],
)
def test_what_is_no_status_is_reported_with_its_file_and_line(
    play: Any, write: Any, returned: str, message: str
) -> None:
    """The mission fails, and says where and what to write."""
    write(f"class Words(Behaviour):\n    def update(self):\n        return {returned}\n")
    run = play("  python: 'own.py:Words'")
    run.tick()
    reason = run.executive.reason
    assert "Words.update() (own.py:8)" in reason
    assert message in reason
    assert ("; write Status.SUCCESS" in reason) is (returned == "'SUCCESS'")


def test_a_leaf_that_blocks_is_named_once_and_not_in_the_trace(
    play: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the wall, which says that each tick has taken so long; most leaves do not block."""
    tree = "  python: own_leaves.py:Countdown\n  inputs: {ticks: 3}"
    run = play(tree)
    run.tick(3)
    assert run.warned == []

    class SlowWall:
        elapsed_s = 2.4

    monkeypatch.setattr(python_leaf, "Stopwatch", SlowWall)
    run = play(tree)
    run.tick(3)
    (warning,) = run.warned
    assert "(own_leaves.py:Countdown) blocked a tick for 2.4 s of wall time" in warning
    assert run.logged == []
