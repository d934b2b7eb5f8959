"""A mission that runs between the page's requests."""

from __future__ import annotations

from collections.abc import Generator
from functools import partial
from types import SimpleNamespace
from typing import Any

import pytest

from bt_mission.cli import run_shown
from bt_mission.cli.main import make_parser
from bt_mission.executive.report import Report
from bt_mission.sessions import watching
from tests.support.watched import ScriptedRun


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Any:
    """Show a session; when it has ended, and its user was told, they leave."""

    def leave(session: ScriptedRun, verdict: str) -> str:
        session.interrupts.note("Ctrl-C")
        return f"stays: {verdict}"

    def run(session: ScriptedRun, steps: Generator[float, None, Report] | None = None) -> list[str]:
        monkeypatch.setattr(watching, "SessionGraph", lambda _: session.graph)
        monkeypatch.setattr(run_shown, "page_stays", partial(leave, session))
        options = make_parser().parse_args(["run", "x.yaml", "--web", "--port", "0"])
        stage: Any = SimpleNamespace(now_ns=0, runs=[None])
        taken = steps or session.steps()
        report = run_shown.shown_on_page(options, stage, taken, session.interrupts, None)
        assert report.status == "success"
        return capsys.readouterr().err.splitlines()[1:]  # without the link

    return run


def test_the_page_stays_when_the_mission_has_ended_until_somebody_leaves(run: Any):
    """With a line that says so, and the verdict."""
    session = ScriptedRun(5)
    assert run(session) == ["stays: success"]
    assert session.taken == 5


def test_who_leaves_early_still_has_every_step_taken(run: Any):
    """The session itself receives the signal, and ends in good order."""
    session = ScriptedRun(50)
    session.interrupts.note("Ctrl-C")
    assert run(session) == []
    assert session.taken == 0


def test_a_page_that_fails_ends_nothing(run: Any, monkeypatch: pytest.MonkeyPatch):
    """The mission goes on, and its user is told."""
    session = ScriptedRun(500)

    def fail() -> None:
        raise ValueError("a defect")

    monkeypatch.setattr(session.graph, "serve", fail)
    assert run(session) == ["the page failed; the mission continues: ValueError: a defect"]
    assert session.taken == 500


def test_an_exception_of_the_session_closes_the_page(run: Any):
    """It is raised for the command, which ends with it; no signal is needed."""
    session = ScriptedRun(50)
    with pytest.raises(ValueError, match="a defect"):
        run(session, session.broken_steps())
    assert session.taken == 50
