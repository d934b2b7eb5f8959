"""A mission that runs within the view's own loop."""

from __future__ import annotations

import asyncio
import itertools
import signal
from collections.abc import Generator
from types import SimpleNamespace
from typing import Any

import pytest

from bt_mission.executive.report import Report
from bt_mission.views.terminal.marks import SIGNS
from bt_mission.views.tui.run_app import RunApp
from tests.support.screens import Screen
from tests.support.watched import ScriptedRun


def app_of(run: ScriptedRun, steps: Generator[float, None, Report] | None = None) -> RunApp[Report]:
    """The view of a run."""
    return RunApp(run.graph, SIGNS, run.executive.name, steps or run.steps(), run.interrupts)


def on_run(play: Any, count: int) -> ScriptedRun:
    """Play a scene on the view of a run of so many steps."""
    run = ScriptedRun(count)

    async def scene() -> None:
        app = app_of(run)
        async with app.run_test(size=(80, 24)) as pilot:
            await pilot.pause()
            await play(Screen(app, pilot, run.graph))

    asyncio.run(scene())
    return run


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
        assert screen.app.report.reason == "user request"  # type: ignore[attr-defined]

    assert on_run(play, 1_000_000).interrupts.count == 1


def test_a_signal_leaves_a_mission_that_has_ended():
    """SIGHUP comes when the terminal is closed: nobody can press q."""

    async def play(screen: Screen) -> None:
        await ended(screen)
        assert not screen.app._exit
        with screen.app._interrupts:  # type: ignore[attr-defined]
            signal.raise_signal(signal.SIGHUP)
        while not screen.app._exit:
            await screen.pilot.pause(0.001)

    on_run(play, 5)


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
    app = app_of(ScriptedRun(1_000_000))
    monkeypatch.setattr(app, "run", lambda: None)
    assert app.run_to_the_end().reason == "the end of the view"


def test_a_slow_machine_loses_no_step(monkeypatch: pytest.MonkeyPatch):
    """Steps are due in 1 ms, and each look at the clock comes later than that."""
    looks = itertools.count()
    monkeypatch.setattr("textual.timer._time", SimpleNamespace(get_time=lambda: next(looks) / 500))

    async def play(screen: Screen) -> None:
        for _ in range(50):
            await screen.pilot.pause(0.001)
        assert screen.app.report is not None  # type: ignore[attr-defined]

    assert on_run(play, 5).taken == 5


def test_an_exception_of_the_session_closes_the_view(monkeypatch: pytest.MonkeyPatch):
    """It is raised for the command, once the terminal is as before."""
    run = ScriptedRun(5)
    app = app_of(run, run.broken_steps())

    async def scene() -> None:
        async with app.run_test(size=(80, 24)) as pilot:
            while not app._exit:
                await pilot.pause(0.001)

    monkeypatch.setattr(app, "run", lambda: asyncio.run(scene()))
    with pytest.raises(ValueError, match="a defect"):
        app.run_to_the_end()
