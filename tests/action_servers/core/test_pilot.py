"""Facts about the one owner of the base."""

from __future__ import annotations

import math
from typing import Any

import pytest

from action_servers.core.governor import Governor
from action_servers.core.maneuver import (
    SUCCEEDED,
    ZERO,
    ErrorCode,
    Finished,
    Maneuver,
    Observation,
    Reason,
)
from action_servers.core.pilot import ManeuverOutcome, ManeuverRun, Pilot
from bt_mission.base.geometry import Twist2D
from bt_mission.robots.model import load_robot
from tests.support.fake_robot import in_the_open

FORWARD = Twist2D(0.2, 0.1)


class Scripted:
    """A maneuver that answers what it is told to; an exception in the script is raised."""

    def __init__(self, *answers: Any, needs_base: bool = True) -> None:
        self.needs_base = needs_base
        self.answers = list(answers)
        self.held: list[Reason | None] = []
        self.next_feedback: Any = None
        self.outcome: Any = None

    def step(self, now: Observation) -> Twist2D | Finished:
        self.held.append(now.held_by)
        return raised_or(self.answers.pop(0) if self.answers else FORWARD)

    def feedback(self) -> Any:
        reported, self.next_feedback = self.next_feedback, None
        return raised_or(reported)

    def result(self) -> Any:
        return raised_or(self.outcome or {"steps": self.steps})

    @property
    def steps(self) -> int:
        return len(self.held)


def raised_or(value: Any) -> Any:
    """Raise an exception; return anything else."""
    if isinstance(value, Exception):
        raise value
    return value


class Bench:
    """A pilot whose commands, feedback and ends are written down in one list, in their order."""

    def __init__(self) -> None:
        self.events: list[Any] = []
        self.observations = 0
        self.fault: Exception | None = None
        self.set_back_s = 0.0
        self.pilot = Pilot(self.observe, self.events.append, Governor(load_robot("waffle")))

    def observe(self) -> Observation:
        self.observations += 1
        raised_or(self.fault)
        return in_the_open(self.observations - self.set_back_s)

    def start(self, maneuver: Maneuver, name: str = "goal") -> ManeuverRun:
        run = ManeuverRun(
            maneuver,
            on_feedback=lambda fields: self.events.append((name, "feedback", fields)),
            on_end=lambda outcome: self.events.append((name, outcome)),
        )
        self.pilot.start(run)
        return run

    def step(self, count: int = 1) -> None:
        for _ in range(count):
            self.pilot.step()


@pytest.fixture
def bench():
    """A pilot on a bench."""
    return Bench()


def test_commands_what_the_maneuver_answers_once_a_control_step(bench):
    """And nothing at the start."""
    bench.start(Scripted(FORWARD, ZERO, FORWARD))
    assert bench.events == []
    bench.step(3)
    assert bench.events == [FORWARD, ZERO, FORWARD]


def test_idle_pilot_neither_observes_nor_commands(bench):
    """Somebody else may drive the base while no goal is active."""
    bench.step()
    assert (bench.events, bench.observations, bench.pilot.idle) == ([], 0, True)


@pytest.mark.parametrize(
    "finished", [SUCCEEDED, Finished("aborted", ErrorCode.BLOCKED, "blocked: no progress")]
)
def test_zero_is_commanded_before_the_end_is_told(bench, finished):
    """And the last feedback between them."""
    maneuver = Scripted(FORWARD, finished)
    bench.start(maneuver)
    bench.step()
    maneuver.next_feedback = {"distance": 1.0}
    bench.step(2)
    outcome = ManeuverOutcome(finished.status, finished.error_code, finished.reason, {"steps": 2})
    end = [("goal", "feedback", {"distance": 1.0}), ("goal", outcome)]
    assert bench.events == [FORWARD, ZERO, *end]
    assert maneuver.steps == 2


def test_feedback_is_given_with_its_step(bench):
    """And left out when the maneuver has nothing new."""
    maneuver = Scripted()
    bench.start(maneuver)
    maneuver.next_feedback = {"angle": 3.0}
    bench.step(2)
    assert bench.events == [("goal", "feedback", {"angle": 3.0}), FORWARD, FORWARD]


@pytest.mark.parametrize("steps", [0, 1])
def test_cancel_commands_zero_at_once(bench, steps):
    """Not at the next control step; also before the first, with a result all the same."""
    run = bench.start(Scripted())
    bench.step(steps)
    bench.events.clear()
    bench.pilot.cancel(run)
    assert bench.events == [ZERO, ("goal", ManeuverOutcome("canceled", result={"steps": steps}))]
    assert bench.pilot.idle


def test_a_late_cancel_of_a_replaced_goal_leaves_the_new_one_running(bench):
    """The old one has ended, with its reason, before the new one was taken in."""
    old = bench.start(Scripted(), "old")
    new = Scripted()
    bench.start(new, "new")
    bench.pilot.cancel(old)
    bench.step()
    replaced = ManeuverOutcome("aborted", ErrorCode.STOPPED, "replaced by a new goal", {"steps": 0})
    assert bench.events == [ZERO, ("old", replaced), FORWARD]
    assert new.steps == 1


@pytest.mark.parametrize("where", ["step", "feedback", "result"])
def test_a_maneuver_that_raises_is_aborted_with_the_cause(bench, where):
    """The robot is stopped, and the pilot goes on with the next goal."""
    error = ZeroDivisionError("float division by zero")
    maneuver = Scripted(FORWARD, error if where == "step" else SUCCEEDED)
    bench.start(maneuver)
    bench.step()
    bench.events.clear()
    if where == "feedback":
        maneuver.next_feedback = error
    elif where == "result":
        maneuver.outcome = error
    bench.step()

    stop, (_, outcome) = bench.events
    assert stop == ZERO
    assert (outcome.status, outcome.error_code) == ("aborted", ErrorCode.UNKNOWN)
    assert outcome.reason == "ZeroDivisionError: float division by zero"
    assert outcome.cause is error

    bench.start(Scripted())
    bench.step()
    assert bench.events[-1] == FORWARD


def test_an_observation_that_fails_stops_everything(bench):
    """Whatever a message held."""
    bench.start(Scripted())
    bench.step()
    bench.fault = ValueError("cannot reshape array")
    bench.step()
    assert bench.events[-2] == ZERO
    assert bench.events[-1][1].reason == "ValueError: cannot reshape array"
    assert bench.pilot.idle


@pytest.mark.parametrize(
    "wrong",
    [Twist2D(math.nan, 0.0), Twist2D(0.0, math.inf), Twist2D(0.1, 0.0, math.nan), None, (1, 2)],
)
def test_no_nonsense_reaches_the_base(bench, wrong):
    """What is no finite twist aborts the goal."""
    bench.start(Scripted(wrong))
    bench.step()
    assert bench.events[0] == ZERO
    assert bench.events[1][1].error_code == ErrorCode.UNKNOWN


def test_a_maneuver_without_the_base_runs_beside_one_with_it(bench):
    """It neither replaces it nor commands anything."""
    bench.start(Scripted(), "drive")
    bench.start(Scripted(SUCCEEDED, needs_base=False), "beside")
    bench.step()
    assert bench.events == [FORWARD, ("beside", ManeuverOutcome("succeeded", result={"steps": 1}))]


def test_stop_ends_every_goal_and_always_commands_zero(bench):
    """Also when there is none."""
    bench.start(Scripted(), "drive")
    bench.start(Scripted(needs_base=False), "beside")
    bench.pilot.stop("the server is shutting down")
    ended = [event[1].reason for event in bench.events if isinstance(event, tuple)]
    assert ended == ["the server is shutting down"] * 2
    assert bench.events[0] == bench.events[-1] == ZERO

    bench.events.clear()
    bench.pilot.stop("again")
    assert bench.events == [ZERO]


def test_a_goal_that_is_started_from_within_an_end_survives(bench):
    """A client that reacts at once to the end of its goal starts the next one."""
    following = Scripted()
    run = ManeuverRun(
        Scripted(SUCCEEDED),
        on_feedback=bench.events.append,
        on_end=lambda outcome: bench.start(following, "next"),
    )
    bench.pilot.start(run)
    bench.step(2)
    assert following.steps == 1
    assert bench.events == [ZERO, FORWARD]


def test_a_clock_set_back_between_goals_ends_none(bench):
    """The next goal only knows the time from then on."""
    bench.start(Scripted(SUCCEEDED))
    bench.step(2)
    bench.set_back_s = 10.0
    bench.start(Scripted())
    bench.step()
    assert bench.events[-1] == FORWARD


def test_a_base_that_is_held_stands_while_its_maneuver_goes_on(bench):
    """Zero at once and at each step; the maneuver sees why the base does not follow."""
    maneuver = Scripted()
    bench.start(maneuver)
    bench.step()
    bench.pilot.hold()
    assert bench.events == [FORWARD, ZERO]
    bench.step(2)
    bench.pilot.release()
    bench.step()
    assert bench.events == [FORWARD, ZERO, ZERO, ZERO, FORWARD]
    assert maneuver.held == [None, Reason.EXECUTIVE, Reason.EXECUTIVE, None]


def test_a_goal_that_comes_while_the_base_is_held_waits(bench):
    """Nothing is commanded where nothing drives; the goal has the base afterwards."""
    bench.pilot.hold()
    assert bench.events == []
    bench.start(Scripted())
    bench.step()
    bench.pilot.release()
    bench.step()
    assert bench.events == [ZERO, FORWARD]
