"""A mission that is carried out between the page's requests."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import closing
from dataclasses import replace

import pytest

from bt_mission.executive.report import Report
from bt_mission.sessions.drive import StepDriver
from bt_mission.views.web.live import LiveMission
from bt_mission.views.web.run import ShownRun
from bt_mission.views.web.server import WebServer
from tests.support.watched import ScriptedExecutive, ScriptedGraph
from tests.support.web_pages import ANY_PORT

REPORT = Report(
    "explore", "success", "", None, "waffle", 7, 1.0, 1.0, 1.0, 1, 0, 0, None, None, "hash"
)


class Run:
    """A session of so many steps that is shown; when it has ended, somebody leaves."""

    def __init__(self, count: int) -> None:
        self.executive = ScriptedExecutive()
        self.graph = ScriptedGraph(self.executive)
        self.is_left = False
        self.logged: list[str] = []
        self.taken = 0
        self._count = count

    def steps(self) -> Generator[float, None, Report]:
        self.executive.begin()
        while self.taken < self._count:
            self.taken += 1
            self.executive.change(0.05, drive="running")
            yield 0.0 if self.taken % 2 else 0.001
        return replace(REPORT, reason="ended")

    def say(self, text: str) -> None:
        self.logged.append(text)
        self.is_left = True

    def carry_out(self) -> Report:
        shown = LiveMission(self.graph)
        with closing(WebServer(shown, ANY_PORT)) as server:
            run = ShownRun(server, StepDriver(self.steps()), lambda: self.is_left, self.say)
            return run.run_to_the_end()


def test_the_page_stays_when_the_mission_has_ended_until_somebody_leaves():
    """With a word on how, and on what it came to."""
    run = Run(5)
    assert run.carry_out().reason == "ended"
    assert run.taken == 5
    assert run.logged == ["the mission has ended: success; the page stays until Ctrl-C"]


def test_who_leaves_early_still_has_every_step_taken():
    """The session itself hears of the wish, and ends in good order."""
    run = Run(50)
    run.is_left = True
    assert run.carry_out().reason == "ended"
    assert run.taken == 50


def test_a_page_that_fails_ends_nothing(monkeypatch: pytest.MonkeyPatch):
    """The mission goes on, and its user is told."""
    run = Run(500)

    def fail() -> None:
        raise ValueError("a defect")

    monkeypatch.setattr(run.graph, "serve", fail)
    assert run.carry_out().reason == "ended"
    assert run.taken == 500
    assert run.logged == ["the page failed; the mission continues: ValueError: a defect"]


def test_an_exception_of_the_session_closes_the_page():
    """It is raised for the command, which ends with it; no signal is needed."""
    run = Run(50)

    def broken() -> Generator[float, None, Report]:
        yield from run.steps()
        raise ValueError("a defect")

    with closing(WebServer(LiveMission(run.graph), ANY_PORT)) as server:
        shown = ShownRun(server, StepDriver(broken()), lambda: False, run.say)
        with pytest.raises(ValueError, match="a defect"):
            shown.run_to_the_end()
    assert run.taken == 50
    assert run.logged == []
