"""A session is driven to its end, whoever looks on."""

from __future__ import annotations

import signal
from typing import Any

import pytest

from bt_mission.base import interrupts
from bt_mission.executive.events.events import Event
from bt_mission.sessions.drive import StepDriver, drive
from bt_mission.sessions.session import MissionRun, StepCallback
from bt_mission.sessions.view import View

DRIVE = """\
mission: drive
world: empty_arena
tree:
  sequence:
    - explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.3}
      timeout: 60
"""


class ClosedPipe(View):
    """A view whose reader leaves when the first leaf starts."""

    def __init__(self) -> None:
        self.shown = 0

    def on_event(self, run: MissionRun, event: Event) -> None:
        self.shown += 1
        raise BrokenPipeError


class Signals(View):
    """A view that sends this process a signal after some frames."""

    def __init__(self, *frames: int) -> None:
        self._frames = frames
        self._count = 0

    def refresh(self) -> None:
        self._count += 1
        if self._count in self._frames:
            signal.raise_signal(signal.SIGINT)


def test_a_reader_who_leaves_ends_the_mission_in_good_order(stage: Any) -> None:
    """The goal is cancelled and confirmed; nothing more is shown."""
    run = stage.run(DRIVE)
    view = ClosedPipe()
    (report,) = drive(run.stage, [view])
    assert report.status == "interrupted"
    assert report.reason == "the output was closed"
    assert report.goals_left_behind == 0
    assert view.shown == 1


def test_ctrl_c_ends_the_mission_and_gives_the_handlers_back(stage: Any) -> None:
    """Afterwards Ctrl-C is Python's again."""
    before = signal.getsignal(signal.SIGINT)
    run = stage.run(DRIVE)
    (report,) = drive(run.stage, [Signals(40)])
    assert (report.status, report.reason) == ("interrupted", "interrupted by Ctrl-C")
    assert (report.goals_sent, report.goals_left_behind) == (1, 0)
    assert signal.getsignal(signal.SIGINT) is before


def test_a_second_ctrl_c_leaves_at_once_and_names_the_goals(
    stage: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Both arrive between two steps: nothing is waited for."""
    monkeypatch.setattr(interrupts, "SAME_WISH_S", 0.0)
    run = stage.run(DRIVE)

    class Twice(Signals):
        def refresh(self) -> None:
            super().refresh()
            if self._count == 40:
                signal.raise_signal(signal.SIGINT)

    (report,) = drive(run.stage, [Twice(40)])
    assert report.goals_left_behind == 1
    assert "ended at once by a second Ctrl-C; orphaned goals: /explore_forward" in report.reason
    assert len(run.close()) == 1


def broken(*_: Any) -> None:
    """Raise whenever it is called."""
    raise RuntimeError("broken for good")


@pytest.mark.parametrize(
    "subscribe",
    [
        lambda stage: stage.executive.events.subscribe,
        lambda stage: stage.executive.after_tick.append,
        lambda stage: stage.trace.lines.subscribe,
        lambda stage: lambda call: stage.attach(StepCallback(call)),
    ],
    ids=["events", "ticks", "trace", "steps"],
)
def test_a_callback_that_raises_ends_the_mission_in_good_order(stage: Any, subscribe: Any) -> None:
    """Whoever calls it: the goal is cancelled and confirmed, and the reason says what it was."""
    run = stage.run(DRIVE)
    while run.t < 1:
        run.stage.step()
    subscribe(run.stage)(broken)
    run.stage.executive.pause("so that a node changes")
    run.stage.executive.resume()
    (report,) = drive(run.stage)
    assert report.status == "failure"
    assert "RuntimeError: broken for good (test_session.py:" in report.reason
    assert report.goals_sent >= 1
    assert report.goals_left_behind == 0


def test_an_exception_of_a_step_ends_the_mission_in_good_order(
    stage: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where it comes from beside the callbacks; a second one leaves at once."""
    run = stage.run(DRIVE)
    while run.t < 1:
        run.stage.step()
    step = run.stage.step
    raised: list[float] = []

    def step_once_broken() -> None:
        step()
        if len(raised) < 1:
            raised.append(run.t)
            raise KeyError("a defect")

    monkeypatch.setattr(run.stage, "step", step_once_broken)
    (report,) = drive(run.stage)
    assert report.reason.startswith("a callback failed: KeyError: 'a defect' (test_session.py:")
    assert report.goals_left_behind == 0
    run = stage.run(DRIVE)
    while run.t < 1:
        run.stage.step()
    monkeypatch.setattr(run.stage, "step", broken)
    (report,) = drive(run.stage)
    assert "broken for good" in report.reason
    assert report.goals_left_behind == 1
    run.close()


def test_a_driver_keeps_what_its_steps_raise() -> None:
    """An event loop would only report it, and wait for a step that never comes."""

    def steps() -> Any:
        yield 0.0
        raise ValueError("a defect")

    driver = StepDriver[None](steps())
    driver.advance()
    assert driver.is_over
    driver.advance()
    with pytest.raises(ValueError, match="a defect"):
        driver.finish()
