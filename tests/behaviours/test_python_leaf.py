"""Behaviours of a user's own, in a mission."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

from tests.support.project import ROOT

CODE = ROOT / "docs" / "tutorials" / "code"


@pytest.fixture(autouse=True)
def beside_the_code(monkeypatch: pytest.MonkeyPatch) -> None:
    """A text as a mission has no folder but the one we are in."""
    monkeypatch.chdir(CODE)


def test_inputs_are_set_at_each_entry_and_outputs_read_at_the_end(play: Any) -> None:
    """The loop hands another number over each time."""
    story = play(
        "  for_each: {n: [1, 2]}\n  do:\n    sequence:\n"
        "      - python: own_leaves.py:Countdown\n"
        "        inputs: {ticks: $n}\n        outputs: {said: last}\n"
        "      - log: $last"
    )
    assert story.tick() == "RSSS"
    assert story.tick() == "RRRI"
    assert story.tick() == "SSSS"
    assert story.said == ["0 to go", "0 to go"]


def test_it_is_given_the_runtime(play: Any) -> None:
    """It reads the mission's clock, and keeps its own state from one entry to the next."""
    story = play(
        "  repeat: {count: 2}\n  do: {python: 'own_leaves.py:Slower', inputs: {seconds: 0.1}}"
    )
    assert story.tick(3) == "RS"
    assert story.tick(5) == "SS"
    assert story.said == ["waited for 0.10 s", "waited for 0.20 s"]


def test_an_exception_halts_the_tree_and_cancels_every_goal(
    play: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The mission fails with the cause and its place; nothing goes on."""
    (tmp_path / "bad.py").write_text(
        "from py_trees.behaviour import Behaviour\n\n"
        "class Bad(Behaviour):\n    def update(self):\n        raise ValueError('no')\n"
    )
    monkeypatch.chdir(tmp_path)
    story = play(
        "  parallel:\n    - {turn: {angle: 90}, timeout: 9}\n"
        "    - sequence: [{wait: 0.05}, {python: 'bad.py:Bad'}]"
    )
    story.tick()
    story.turn.accept()
    story.tick()
    assert story.executive.reason == "ValueError: no (bad.py:5)"
    assert story.turn.cancels == [story.turn.goal]
    story.turn.cancel(None)
    story.tick()
    assert story.status == "failure"
    assert story.executive.goals_left_behind == ()


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
    story = play(
        "  parallel:\n    - {python: 'halted.py:Halted', outputs: {seen: s}}\n    - wait: 0.05\n"
        "  succeed_when: any"
    )
    story.tick(2)
    (module,) = [one for name, one in sys.modules.items() if name.endswith("_halted")]
    assert module.Halted.seen == "INVALID"
    assert "s" not in story.scope.values
