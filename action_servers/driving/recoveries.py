"""The common part of Nav2's recoveries, and its Wait: codes and a time allowance.

Behaviour and codes follow the behaviour server of Nav2 for ROS 2 Jazzy: a goal that cannot be run
is accepted and then aborted, a time allowance of 0 is no limit, and every result has the time that
was used. Numbers that are not finite, and speeds that the robot does not have, are rejected, which
a client of Nav2 handles, too.
"""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass
from typing import Any

from action_servers.core.action import Action
from action_servers.core.limits import NOT_NEGATIVE, NumberLimit
from action_servers.core.maneuver import SUCCEEDED, ZERO, ErrorCode, Fields, Finished, Observation
from action_servers.core.progress import ROUNDING_S, ChangedFields, Ticker
from bt_mission.base.geometry import Twist2D
from bt_mission.base.stamps import NS, to_ns

ALLOWANCE = NumberLimit(
    field="time_allowance", low=0.0, high=math.inf, unit="s", source=NOT_NEGATIVE
)
"""The limit of the time allowance."""


@dataclass(frozen=True, slots=True)
class Codes:
    """The numbers of one of Nav2's recoveries; `invalid_input` is 0 where it has none."""

    unknown: int
    timeout: int
    tf_error: int
    collision_ahead: int
    invalid_input: int = 0

    @property
    def numbers(self) -> tuple[int, ...]:
        """All of its numbers, in ascending order."""
        return tuple(sorted(filter(None, astuple(self))))

    def of(self, code: int) -> int:
        """Return the number of a reason for which we have a code."""
        return {
            ErrorCode.NONE: 0,
            ErrorCode.NO_ODOMETRY: self.tf_error,
            ErrorCode.BLOCKED: self.collision_ahead,
        }.get(ErrorCode(code), self.unknown)


class Allowance(Ticker):
    """The time since the first control step, and whether more is used than `seconds` (0: any)."""

    def __init__(self, seconds: float, codes: Codes) -> None:
        super().__init__()
        self._seconds = seconds
        self._codes = codes

    def late(self, now: Observation) -> Finished | None:
        """Note the time; return the end of the goal once its allowance is used up."""
        self.update(now.time_s)
        if not self._seconds or self.elapsed_s <= self._seconds + ROUNDING_S:
            return None
        reason = f"the time allowance of {self._seconds:g} s is used up"
        return Finished("aborted", self._codes.timeout, reason)


def plan_wait(goal: Any, _now: Observation) -> WaitManeuver:
    """Return the maneuver for a goal; 0 s ends at once."""
    return WaitManeuver(to_ns(goal.time) / NS)


class WaitManeuver:
    """Ends after `seconds` of ROS time."""

    needs_base = False

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._ticker = Ticker()
        self._changed = ChangedFields()

    def step(self, now: Observation) -> Twist2D | Finished:
        """Wait on, or end."""
        self._ticker.update(now.time_s)
        return SUCCEEDED if self._ticker.has_reached(self._seconds) else ZERO

    def feedback(self) -> Fields | None:
        """Return the remaining time when it has changed."""
        return self._changed.of({"time_left": max(0.0, self._seconds - self._ticker.elapsed_s)})

    def result(self) -> Fields:
        """Return the time that has passed."""
        return {"total_elapsed_time": self._ticker.elapsed_s}


WAIT = Action(
    name="wait",
    short="",  # the language has a node for this
    type="nav2_msgs/action/Wait",
    needs=(),
    example={"time": 10},
    plan=plan_wait,
    limits=lambda _robot, _tuning: (
        NumberLimit(field="time", low=0.0, high=math.inf, unit="s", source=NOT_NEGATIVE),
    ),
)
