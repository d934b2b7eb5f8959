"""A mission that is carried out within the view's own loop."""

from __future__ import annotations

import asyncio
from collections.abc import Generator
from dataclasses import replace
from typing import Any

import pytest

from bt_mission.core.interrupts import InterruptSignals
from bt_mission.executive.report import Report
from bt_mission.views.terminal.marks import SIGNS
from bt_mission.views.tui.run_app import RunApp
from tests.support.screens import Screen
from tests.support.watched import ScriptedExecutive, ScriptedGraph

REPORT = Report(
    "explore", "success", "", None, "waffle", 7, 1.0, 1.0, 1.0, 1, 0, 0, None, None, "hash"
)


class Drive:
    """A session that takes so many steps, and ends when it is interrupted."""

    def __init__(self, executive: ScriptedExecutive, count: int) -> None:
        self.interrupts = InterruptSignals()
        self.taken = 0
        self._executive = executive
        self._count = count

    def steps(self) -> Generator[float, None, Report]:
        self._executive.begin()
        while self.taken < self._count and not self.interrupts.count:
            self.taken += 1
            self._executive.change(0.05, drive="running")
            yield 0.0 if self.taken % 2 else 0.001
        self._executive.stand("success")
        return replace(REPORT, reason=self.interrupts.name)


def on_run(play: Any, count: int) -> Drive:
    """Play a scene on the view of a run of so many steps."""
    executive = ScriptedExecutive()
    drive = Drive(executive, count)

    async def scene() -> None:
        graph = ScriptedGraph(executive)
        app = RunApp(graph, SIGNS, executive.name, drive.steps(), drive.interrupts)
        async with app.run_test(size=(80, 24)) as pilot:
            await pilot.pause()
            await play(Screen(app, pilot, graph))

    asyncio.run(scene())
    return drive


async def ended(screen: Screen) -> None:
    """Wait until all steps are taken."""
    while screen.app.report is None:  # type: ignore[attr-defined]
        await screen.pilot.pause(0.001)


def test_the_picture_stays_when_the_mission_has_ended():
    """With a word on how to leave; wishes are in vain."""

    async def play(screen: Screen) -> None:
        await ended(screen)
        await screen.look()
        assert screen.rows[0].startswith("explore  ✓ success")
        assert screen.rows[-1] == "the mission has ended; q exits"
        assert "▶ drive" in screen.text, "its first step was seen"
        await screen.press("p")
        assert screen.rows[-1] == "the mission has ended"
        assert screen.executive.commands == []
        await screen.press("q")
        assert screen.app._exit

    assert on_run(play, 5).taken == 5


def test_leaving_ends_the_mission_first():
    """As Ctrl-C does without a picture; the view stays until it has ended."""

    async def play(screen: Screen) -> None:
        await screen.press("q")
        assert not screen.app._exit
        await ended(screen)
        assert screen.app.report.reason == "the user"  # type: ignore[attr-defined]

    drive = on_run(play, 1_000_000)
    assert drive.interrupts.count == 1


def test_leaving_twice_leaves_at_once():
    """Whatever has not ended by then."""

    async def play(screen: Screen) -> None:
        screen.app._step_driver._steps = iter(lambda: 10.0, None)  # type: ignore[attr-defined]
        await screen.press("q")
        assert not screen.app._exit
        await screen.press("q")
        assert screen.app._exit

    assert on_run(play, 1_000_000).interrupts.count == 2


def test_a_view_that_breaks_ends_the_mission_in_good_order(monkeypatch: pytest.MonkeyPatch):
    """All its steps are taken, and the report is there."""
    executive = ScriptedExecutive()
    drive = Drive(executive, 1_000_000)
    graph = ScriptedGraph(executive)
    app = RunApp(graph, SIGNS, executive.name, drive.steps(), drive.interrupts)
    monkeypatch.setattr(app, "run", lambda: None)
    assert app.run_to_the_end().reason == "the end of the view"


def test_an_exception_of_the_session_closes_the_view(monkeypatch: pytest.MonkeyPatch):
    """It is raised for the command, once the terminal is as before."""
    executive = ScriptedExecutive()
    drive = Drive(executive, 5)

    def broken() -> Generator[float, None, Report]:
        yield from drive.steps()
        raise ValueError("a defect")

    app = RunApp(ScriptedGraph(executive), SIGNS, executive.name, broken(), drive.interrupts)

    async def scene() -> None:
        async with app.run_test(size=(80, 24)) as pilot:
            while not app._exit:
                await pilot.pause(0.001)

    monkeypatch.setattr(app, "run", lambda: asyncio.run(scene()))
    with pytest.raises(ValueError, match="a defect"):
        app.run_to_the_end()
