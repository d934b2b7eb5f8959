"""Facts about the one owner of the base."""

from __future__ import annotations

import math
from typing import Any

import pytest

from action_servers.core.error_codes import ErrorCode
from action_servers.core.governor import Governor
from action_servers.core.maneuver import SUCCEEDED, ZERO, Finished, Maneuver, Observation
from action_servers.core.pilot import ManeuverOutcome, ManeuverRun, Pilot
from bt_mission.core.geometry import Twist2D
from bt_mission.core.robot.model import load_robot
from tests.support.fake_robot import in_the_open

FORWARD = Twist2D(0.2, 0.1)


class Scripted:
    """A maneuver that answers what it is told to; an exception in the script is raised."""

    def __init__(self, *answers: Any, needs_base: bool = True) -> None:
        self.needs_base = needs_base
        self.answers = list(answers)
        self.steps = 0
        self.next_feedback: Any = None
        self.outcome: Any = {"steps": 0}

    def step(self, now: Observation) -> Twist2D | Finished:
        self.steps += 1
        answer = self.answers.pop(0) if self.answers else FORWARD
        if isinstance(answer, Exception):
            raise answer
        return answer

    def feedback(self) -> Any:
        reported, self.next_feedback = self.next_feedback, None
        if isinstance(reported, Exception):
            raise reported
        return reported

    def result(self) -> Any:
        if isinstance(self.outcome, Exception):
            raise self.outcome
        return {"steps": self.steps}


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
        if self.fault is not None:
            raise self.fault
        return in_the_open(self.observations - self.set_back_s)

    def start(self, maneuver: Maneuver, name: str = "goal") -> ManeuverRun:
        run = ManeuverRun(
            maneuver,
            on_feedback=lambda fields: self.events.append((name, "feedback", fields)),
            on_end=lambda outcome: self.events.append((name, outcome)),
        )
        self.pilot.start(run)
        return run


@pytest.fixture
def bench():
    """A pilot on a bench."""
    return Bench()


def test_commands_what_the_maneuver_answers(bench):
    """One command per control step."""
    bench.start(Scripted(FORWARD, ZERO, FORWARD))
    for _ in range(3):
        bench.pilot.step()
    assert bench.events == [FORWARD, ZERO, FORWARD]


def test_starting_commands_nothing(bench):
    """The first command comes with the first control step."""
    bench.start(Scripted())
    assert bench.events == []
    assert not bench.pilot.idle


def test_idle_pilot_neither_observes_nor_commands(bench):
    """Somebody else may drive the base while no goal is active."""
    bench.pilot.step()
    assert bench.events == []
    assert bench.observations == 0
    assert bench.pilot.idle


@pytest.mark.parametrize(
    "finished", [SUCCEEDED, Finished("aborted", ErrorCode.BLOCKED, "blocked: no progress")]
)
def test_zero_is_commanded_before_the_end_is_told(bench, finished):
    """And the last feedback between them."""
    maneuver = Scripted(FORWARD, finished)
    bench.start(maneuver)
    bench.pilot.step()
    maneuver.next_feedback = {"distance": 1.0}
    bench.pilot.step()
    outcome = ManeuverOutcome(finished.status, finished.error_code, finished.reason, {"steps": 2})
    assert bench.events == [
        FORWARD,
        ZERO,
        ("goal", "feedback", {"distance": 1.0}),
        ("goal", outcome),
    ]
    bench.pilot.step()
    assert maneuver.steps == 2


def test_feedback_is_given_with_its_step(bench):
    """And left out when the maneuver has nothing new."""
    maneuver = Scripted()
    bench.start(maneuver)
    maneuver.next_feedback = {"angle": 3.0}
    bench.pilot.step()
    bench.pilot.step()
    assert bench.events == [("goal", "feedback", {"angle": 3.0}), FORWARD, FORWARD]


def test_cancel_commands_zero_at_once(bench):
    """Not at the next control step."""
    run = bench.start(Scripted())
    bench.pilot.step()
    bench.pilot.cancel(run)
    assert bench.events == [
        FORWARD,
        ZERO,
        ("goal", ManeuverOutcome("canceled", result={"steps": 1})),
    ]
    assert bench.pilot.idle


def test_cancel_before_the_first_step(bench):
    """The goal has a result all the same."""
    run = bench.start(Scripted())
    bench.pilot.cancel(run)
    assert bench.events == [ZERO, ("goal", ManeuverOutcome("canceled", result={"steps": 0}))]


def test_cancel_after_the_end_changes_nothing(bench):
    """A maneuver ends once."""
    run = bench.start(Scripted(SUCCEEDED))
    bench.pilot.step()
    before = list(bench.events)
    bench.pilot.cancel(run)
    assert bench.events == before


def test_a_new_goal_replaces_the_old_one(bench):
    """The old one ends, with zero velocity and a reason, before the new one is taken in."""
    bench.start(Scripted(), "old")
    bench.pilot.step()
    new = Scripted(ZERO)
    bench.start(new, "new")
    assert bench.events == [
        FORWARD,
        ZERO,
        (
            "old",
            ManeuverOutcome("aborted", ErrorCode.STOPPED, "replaced by a new goal", {"steps": 1}),
        ),
    ]
    bench.pilot.step()
    assert new.steps == 1


def test_ends_of_replaced_goals_do_not_touch_the_new_one(bench):
    """A late cancel of the old goal leaves the new one running."""
    old = bench.start(Scripted(), "old")
    new = Scripted()
    bench.start(new, "new")
    bench.pilot.cancel(old)
    bench.pilot.step()
    assert new.steps == 1
    assert bench.events[-1] == FORWARD


def test_a_burst_of_goals_leaves_the_last(bench):
    """Each of the others ends exactly once."""
    for number in range(20):
        bench.start(Scripted(), f"goal {number}")
    bench.pilot.step()
    ended = [event[0] for event in bench.events if isinstance(event, tuple)]
    assert ended == [f"goal {number}" for number in range(19)]
    assert bench.events[-1] == FORWARD


@pytest.mark.parametrize("where", ["step", "feedback", "result"])
def test_a_maneuver_that_raises_is_aborted_with_the_cause(bench, where):
    """The robot is stopped, and the pilot goes on with the next goal."""
    error = ZeroDivisionError("float division by zero")
    maneuver = Scripted(FORWARD, error if where == "step" else SUCCEEDED)
    bench.start(maneuver)
    bench.pilot.step()
    bench.events.clear()
    if where == "feedback":
        maneuver.next_feedback = error
    elif where == "result":
        maneuver.outcome = error
    bench.pilot.step()

    stop, (_, outcome) = bench.events
    assert stop == ZERO
    assert (outcome.status, outcome.error_code) == ("aborted", ErrorCode.UNKNOWN)
    assert outcome.reason == "ZeroDivisionError: float division by zero"
    assert outcome.cause is error

    bench.start(Scripted())
    bench.pilot.step()
    assert bench.events[-1] == FORWARD


def test_a_canceled_goal_stays_canceled_when_its_result_fails(bench):
    """It ends without a result."""
    maneuver = Scripted()
    maneuver.outcome = RuntimeError("no")
    run = bench.start(maneuver)
    bench.pilot.cancel(run)
    assert bench.events[-1] == ("goal", ManeuverOutcome("canceled"))


def test_an_observation_that_fails_stops_everything(bench):
    """Whatever a message held."""
    bench.start(Scripted())
    bench.pilot.step()
    bench.fault = ValueError("cannot reshape array")
    bench.pilot.step()
    assert bench.events[-2] == ZERO
    assert bench.events[-1][1].reason == "ValueError: cannot reshape array"
    assert bench.pilot.idle


@pytest.mark.parametrize("wrong", [Twist2D(math.nan, 0.0), Twist2D(0.0, math.inf), None, (1, 2)])
def test_no_nonsense_reaches_the_base(bench, wrong):
    """What is no finite twist aborts the goal."""
    bench.start(Scripted(wrong))
    bench.pilot.step()
    assert bench.events[0] == ZERO
    assert bench.events[1][1].error_code == ErrorCode.UNKNOWN


def test_commands_keep_to_the_limits_of_the_robot(bench):
    """Whatever a maneuver wants."""
    bench.start(Scripted(Twist2D(5.0, -9.0), Twist2D(-5.0, 9.0)))
    bench.pilot.step()
    bench.pilot.step()
    assert bench.events == [Twist2D(0.26, -1.82), Twist2D(-0.26, 1.82)]


def test_a_maneuver_without_the_base_runs_beside_one_with_it(bench):
    """It neither replaces it nor commands anything."""
    bench.start(Scripted(), "drive")
    beside = Scripted(SUCCEEDED, needs_base=False)
    bench.start(beside, "beside")
    bench.pilot.step()
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
    bench.pilot.step()
    bench.pilot.step()
    assert following.steps == 1
    assert bench.events == [ZERO, FORWARD]


def test_every_goal_ends_where_the_clock_is_set_back() -> None:
    """What is done for a time would be done for longer; the base stops, and new goals are taken."""
    bench = Bench()
    bench.start(Scripted())
    bench.pilot.step()
    bench.set_back_s = 10.0
    bench.pilot.step()
    reason = "the ROS clock was set back by 9.00 s"
    outcome = ManeuverOutcome("aborted", ErrorCode.STOPPED, reason, result={"steps": 1})
    assert bench.events[-2:] == [ZERO, ("goal", outcome)]
    bench.start(Scripted())
    bench.pilot.step()
    assert bench.events[-1] == FORWARD


def test_a_clock_set_back_between_goals_ends_none() -> None:
    """The next goal only knows the time from then on."""
    bench = Bench()
    bench.start(Scripted(SUCCEEDED))
    bench.pilot.step()
    bench.pilot.step()
    bench.set_back_s = 10.0
    bench.start(Scripted())
    bench.pilot.step()
    assert bench.events[-1] == FORWARD
