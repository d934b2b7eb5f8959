"""What plants a defect: methods that are altered for a test, and some that are wrong."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pytest

from action_servers.core import maneuver, pilot
from action_servers.driving.explore_forward import ExploreForward
from action_servers.driving.turn import Turn
from action_servers.navigation.waypoints import FollowWaypoints
from bt_mission.base.geometry import Twist2D
from bt_mission.executive.goals.attempt import Attempt
from bt_mission.executive.goals.goal import Goal

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


def twisted(owner: Any, change: Callable[[Twist2D], Twist2D], name: str = "step") -> Plant:
    """Plant what alters the commands of a maneuver, and nothing else that it answers."""
    return altered(
        owner, name, lambda answer, *_: change(answer) if isinstance(answer, Twist2D) else answer
    )


def blind(patch: pytest.MonkeyPatch) -> None:
    """Take old scans and odometry for new ones."""
    patch.setattr(maneuver, "overdue", lambda *_: None)


def lost_cancel(self: pilot.Pilot, run: Any) -> None:
    """Do nothing, as if the request had been lost in the server."""


def late_limits(self: Attempt, now_ns: int, by_ns: int = 1_000_000_000) -> None:
    """Mind limits late."""
    check_limits(self, now_ns - by_ns)


def late_condition(self: Attempt, goal: Goal, now_ns: int) -> None:
    """Look at feedback three control steps late."""
    waiting = vars(self).setdefault("waiting", [])
    waiting.append(list(goal.unread))
    goal.unread.clear()
    if len(waiting) > 3:
        goal.unread.extend(waiting.pop(0))
    check_feedback(self, goal, now_ns)


check_limits, check_feedback = Attempt._check_limits, Attempt._check_feedback


def no_zero_at_the_end(
    self: pilot.Pilot, run: Any, outcome: Any, *, with_feedback: bool = False
) -> None:
    """End a maneuver without a command to stand."""
    command, self._command = self._command, lambda _: None
    try:
        end(self, run, outcome, with_feedback=with_feedback)
    finally:
        self._command = command


end = pilot.Pilot._end


def skip(self: FollowWaypoints) -> bool:
    """Leave out the second waypoint."""
    self._index += self._index == 0
    return last_leg(self)


last_leg = FollowWaypoints._last_leg


def first_scan_only(self: ExploreForward, now: Any) -> None:
    """Look once."""
    if self._scan is None:
        look(self, now)


look, gap = ExploreForward._look, ExploreForward._gap


def satisfied(step: Callable[..., Any]) -> Callable[..., Any]:
    """Let a turn count as done where it rests."""

    def done(self: Turn, now: Any) -> Any:
        self._tolerance = math.radians(20)
        return step(self, now)

    return done
