"""Defects that are planted, each of which violates a requirement of a shipped scenario.

What catches a defect is told in the table. Without a defect every scenario comes out as it must, so
that nothing else is what violates the requirement.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from action_servers.camera.camera_sweep import CameraSweep
from action_servers.core import checks, pilot
from action_servers.driving import explore_forward, straight, turn
from action_servers.driving.drive import DriveGuard, Way
from action_servers.driving.explore_forward import ExploreForward
from action_servers.driving.straight import Straight
from action_servers.driving.turn import Rotation, Turn
from action_servers.navigation.follower import Follower
from action_servers.navigation.surroundings import Surroundings
from action_servers.navigation.waypoints import FollowWaypoints
from bt_mission.behaviours.decorators import Repeat
from bt_mission.core.geometry import Twist2D
from bt_mission.goals.attempt import Attempt
from bt_mission.goals.goal import Goal
from bt_mission.scenarios.run import run_scenario

SCENARIOS = Path("missions/scenarios")
Plant = Callable[[pytest.MonkeyPatch], object]


@dataclass(frozen=True)
class Defect:
    """A defect, the scenario that shows it, and the requirement that it violates."""

    what: str
    scenario: str
    caught_by: str
    plant: Plant


def altered(owner: Any, name: str, alter: Callable[..., Any]) -> Plant:
    """Plant what alters the answers of a method: `alter(answer, self, *arguments)`."""
    original = getattr(owner, name)

    def method(self: Any, *args: Any, **kwargs: Any) -> Any:
        return alter(original(self, *args, **kwargs), self, *args)

    return lambda patch: patch.setattr(owner, name, method)


def instead(owner: Any, name: str, other: Any) -> Plant:
    """Plant something in the place of a method or value."""
    return lambda patch: patch.setattr(owner, name, other)


def given(owner: Any, name: str, alter: Callable[..., tuple[Any, ...]]) -> Plant:
    """Plant what alters the arguments of a method."""
    original = getattr(owner, name)

    def method(self: Any, *args: Any, **kwargs: Any) -> Any:
        return original(self, *alter(*args), **kwargs)

    return lambda patch: patch.setattr(owner, name, method)


def twist(change: Callable[[Twist2D], Twist2D]) -> Callable[..., Any]:
    """Alter what is commanded, and nothing else that a maneuver answers."""
    return lambda answer, *_: change(answer) if isinstance(answer, Twist2D) else answer


def _blind(patch: pytest.MonkeyPatch) -> None:
    """Take old scans and odometry for new ones."""
    patch.setattr(checks, "_fault", lambda *_: None)
    patch.setattr(DriveGuard, "_age_s", lambda *_: 0.0)


def _lost_cancel(self: pilot.Pilot, run: Any) -> None:
    """Do nothing, as if the request had been lost in the server."""


def _late_limits(self: Attempt, now_ns: int, by_ns: int = 1_000_000_000) -> None:
    _check_limits(self, now_ns - by_ns)


def _late_condition(self: Attempt, goal: Goal, now_ns: int) -> None:
    """Look at feedback three control steps late."""
    waiting = vars(self).setdefault("waiting", [])
    waiting.append(list(goal.unread))
    goal.unread.clear()
    if len(waiting) > 3:
        goal.unread.extend(waiting.pop(0))
    _check_feedback(self, goal, now_ns)


_check_limits, _check_feedback = Attempt._check_limits, Attempt._check_feedback


def _no_zero_at_the_end(self: pilot.Pilot, run: Any, outcome: Any, *, tell: bool = False) -> None:
    """End a maneuver without a command to stand."""
    command, self._command = self._command, lambda _: None
    try:
        _end(self, run, outcome, tell=tell)
    finally:
        self._command = command


_end = pilot.Pilot._end


def _skip(self: FollowWaypoints) -> bool:
    self._index += self._index == 0
    return _last_leg(self)


_last_leg = FollowWaypoints._last_leg


def _first_scan_only(self: ExploreForward, now: Any) -> None:
    if self._scan is None:
        _look(self, now)


_look, _gap = ExploreForward._look, ExploreForward._gap


DEFECTS = (
    # ---- turning --------------------------------------------------------------------------
    Defect(
        "turns with a wrong sign",
        "square",
        "turns to the left",
        altered(Turn, "step", twist(lambda one: Twist2D(one.linear, -one.angular))),
    ),
    Defect(
        "stops a turn 15 degrees early",
        "square",
        "ends where it began",
        lambda patch: (
            patch.setattr(turn, "ARRIVED_WITHIN", math.radians(15)),
            patch.setattr(Turn, "step", _satisfied(Turn.step)),
        ),
    ),
    Defect(
        "turns a tenth too far",
        "square",
        "ends where it began",
        given(Turn, "__init__", lambda angle, *rest: (1.1 * angle, *rest)),
    ),
    Defect(
        "turns at full speed",
        "square",
        "turns gently",
        given(Turn, "__init__", lambda angle, _, *rest: (angle, 1.8, *rest)),
    ),
    Defect(
        "drives on while it turns",
        "square",
        "turns on the spot",
        altered(Turn, "step", twist(lambda one: Twist2D(0.05, one.angular))),
    ),
    Defect(
        "does not look for room to turn",
        "tight_turn",
        "has room while it turns",
        instead(Rotation, "_look", lambda *_: None),
    ),
    # ---- driving --------------------------------------------------------------------------
    Defect(
        "drives a little to the left",
        "square",
        "drives straight",
        altered(ExploreForward, "step", twist(lambda one: Twist2D(one.linear, 0.15))),
    ),
    Defect(
        "drives backwards",
        "square",
        "drives ahead",
        altered(ExploreForward, "step", twist(lambda one: Twist2D(-one.linear, 0.0))),
    ),
    Defect(
        "drives faster than it was told",
        "square",
        "keeps to its speed",
        given(ExploreForward, "__init__", lambda speed, *rest: (1.3 * speed, *rest)),
    ),
    Defect(
        "counts half of its way",
        "square",
        "keeps within its square",
        altered(
            ExploreForward,
            "feedback",
            lambda said, *_: (
                said
                and {**said, "current_distance_travelled": said["current_distance_travelled"] / 2}
            ),
        ),
    ),
    Defect(
        "stops 0.3 m late",
        "obstacle_appears",
        "stays 0.1 m away",
        given(ExploreForward, "__init__", lambda speed, gap, *rest: (speed, gap - 0.35, *rest)),
    ),
    Defect(
        "does not slow down before an obstacle",
        "obstacle_appears",
        "stays 0.1 m away",
        lambda patch: (
            patch.setattr(DriveGuard, "speed_ahead", lambda _, now, remaining, most: most),
            patch.setattr(explore_forward.ExploreForward, "_gap", lambda self: _gap(self) + 0.3),
        ),
    ),
    Defect(
        "looks at its first scan alone",
        "obstacle_appears",
        "is never hit",
        instead(ExploreForward, "_look", _first_scan_only),
    ),
    Defect("drives on blind", "scan_lost", "stands before it is blind for a second", _blind),
    Defect(
        "is not held while the scan is old",
        "scan_lost",
        "stands before it is blind for a second",
        instead(DriveGuard, "_age_s", lambda *_: 0.0),
    ),
    Defect("drives on without odometry", "odometry_lost", "stops when lost", _blind),
    Defect(
        "commands no zero when a goal ends",
        "limits",
        "goes no farther",
        instead(pilot.Pilot, "_end", _no_zero_at_the_end),
    ),
    # ---- backing up -----------------------------------------------------------------------
    Defect(
        "backs up without a look behind",
        "back_up",
        "is never hit",
        instead(Way, "blocked", lambda *_: None),
    ),
    Defect(
        "backs up with a wrong sign",
        "back_up",
        "backs up",
        altered(Straight, "step", twist(lambda one: Twist2D(-one.linear, one.angular))),
    ),
    Defect(
        "backs up too far",
        "back_up",
        "backs up no farther than it was told",
        given(Straight, "__init__", lambda distance, *rest: (1.1 * distance, *rest)),
    ),
    Defect(
        "stops backing up early",
        "back_up",
        "backs up as far as it was told",
        instead(straight, "ARRIVED_WITHIN", 0.05),
    ),
    # ---- pictures -------------------------------------------------------------------------
    Defect(
        "sweeps to the right",
        "sweep",
        "turns to the left",
        altered(CameraSweep, "step", twist(lambda one: Twist2D(one.linear, -one.angular))),
    ),
    Defect(
        "takes a picture less",
        "sweep",
        "takes every picture",
        given(CameraSweep, "__init__", lambda angle, count, *rest: (angle, count - 1, *rest)),
    ),
    Defect(
        "sweeps three quarters of the angle",
        "sweep",
        "turns half round",
        given(CameraSweep, "__init__", lambda angle, *rest: (0.75 * angle, *rest)),
    ),
    Defect(
        "sweeps too fast",
        "sweep",
        "turns slowly enough for sharp pictures",
        altered(Rotation, "towards", twist(lambda one: Twist2D(0.0, 4.0 * one.angular))),
    ),
    # ---- navigation -----------------------------------------------------------------------
    Defect(
        "skips a waypoint",
        "patrol",
        "comes to B before C",
        instead(FollowWaypoints, "_last_leg", _skip),
    ),
    Defect(
        "visits the waypoints backwards",
        "patrol",
        "comes to A before B",
        given(FollowWaypoints, "__init__", lambda poses, *rest: (poses[::-1], *rest)),
    ),
    Defect(
        "counts as there half a metre away",
        "patrol",
        "stands in D as it was told",
        altered(
            Follower,
            "steer",
            lambda answer, self, *_: None if self.remaining < 0.6 else answer,
        ),
    ),
    Defect(
        "does not turn to the yaw of a pose",
        "patrol",
        "stands in D as it was told",
        altered(Follower, "steer", lambda answer, self, *_: answer if self.remaining else None),
    ),
    Defect(
        "takes the robot for a point",
        "patrol",
        "stays 0.2 m away",
        altered(
            Surroundings,
            "__init__",
            lambda _, self, *__: setattr(
                self, "cost", replace(self.cost, radius=0.02, comfort=0.05, margin=0.005)
            ),
        ),
    ),
    # ---- missions -------------------------------------------------------------------------
    Defect(
        "loses requests to cancel",
        "limits",
        "ends at its distance",
        instead(pilot.Pilot, "cancel", _lost_cancel),
    ),
    Defect(
        "minds a condition three steps late",
        "square",
        "ends a side where it must",
        instead(Attempt, "_check_feedback", _late_condition),
    ),
    Defect(
        "minds a timeout a second late",
        "limits",
        "ends at its time",
        instead(Attempt, "_check_limits", _late_limits),
    ),
    Defect(
        "forgets timeouts",
        "limits",
        "ends at its time",
        instead(Attempt, "_check_limits", lambda *_: None),
    ),
    Defect(
        "repeats once less",
        "square",
        "ends where it began",
        altered(
            Repeat,
            "__init__",
            lambda _, self, *__: setattr(self, "_rounds", replace(self._rounds, count=lambda: 3)),
        ),
    ),
)


def _satisfied(step: Callable[..., Any]) -> Callable[..., Any]:
    """Let a turn count as done where it rests."""

    def done(self: Turn, now: Any) -> Any:
        self._tolerance = math.radians(20)
        return step(self, now)

    return done


@pytest.mark.parametrize("name", sorted({one.scenario for one in DEFECTS}))
def test_without_a_defect(name: str) -> None:
    """Everything comes out as it must."""
    result = run_scenario(SCENARIOS / f"{name}.scenario.yaml")
    assert result.passed, str(result)


@pytest.mark.parametrize("defect", DEFECTS, ids=lambda one: one.what)
def test_a_defect_is_caught(defect: Defect, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the requirement that the table names."""
    defect.plant(monkeypatch)
    result = run_scenario(SCENARIOS / f"{defect.scenario}.scenario.yaml")
    assert defect.caught_by in result.violated, "\n".join(map(str, result.report.requirements))


def test_there_are_thirty() -> None:
    """And no two of one name."""
    assert len({one.what for one in DEFECTS}) >= 30
