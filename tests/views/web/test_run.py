"""A mission that runs between the page's requests."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import closing

import pytest

from bt_mission.executive.report import Report
from bt_mission.sessions.drive import StepDriver
from bt_mission.views.web.live import LiveMission
from bt_mission.views.web.run import ShownRun
from bt_mission.views.web.server import WebServer
from tests.support.watched import ScriptedRun
from tests.support.web_pages import ANY_PORT


class Run(ScriptedRun):
    """A session of so many steps that is shown; when it has ended, somebody leaves."""

    def __init__(self, count: int) -> None:
        super().__init__(count)
        self.is_left = False
        self.logged: list[str] = []

    def say(self, text: str) -> None:
        self.logged.append(text)
        self.is_left = True

    def run(self, steps: Generator[float, None, Report] | None = None) -> None:
        with closing(WebServer(LiveMission(self.graph), ANY_PORT)) as server:
            driver = StepDriver(steps or self.steps())
            shown = ShownRun(server, driver, lambda: self.is_left, self.say)
            assert shown.run_to_the_end().status == "success"


def test_the_page_stays_when_the_mission_has_ended_until_somebody_leaves():
    """With a word on how, and on what it came to."""
    run = Run(5)
    run.run()
    assert run.taken == 5
    assert run.logged == ["the mission has ended: success; the page stays until Ctrl-C"]


def test_who_leaves_early_still_has_every_step_taken():
    """The session itself hears of the wish, and ends in good order."""
    run = Run(50)
    run.is_left = True
    run.run()
    assert run.taken == 50


def test_a_page_that_fails_ends_nothing(monkeypatch: pytest.MonkeyPatch):
    """The mission goes on, and its user is told."""
    run = Run(500)

    def fail() -> None:
        raise ValueError("a defect")

    monkeypatch.setattr(run.graph, "serve", fail)
    run.run()
    assert run.taken == 500
    assert run.logged == ["the page failed; the mission continues: ValueError: a defect"]


def test_an_exception_of_the_session_closes_the_page():
    """It is raised for the command, which ends with it; no signal is needed."""
    run = Run(50)
    with pytest.raises(ValueError, match="a defect"):
        run.run(run.broken_steps())
    assert run.taken == 50
    assert run.logged == []
