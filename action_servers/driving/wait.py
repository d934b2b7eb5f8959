"""Nav2's Wait: let a time pass. The robot may be driven meanwhile."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from action_servers.core.checks import refusal
from action_servers.core.goal_limits import WAIT
from action_servers.core.limits import faults
from action_servers.core.maneuver import SUCCEEDED, ZERO, Finished, Observation, Refusal, Value
from action_servers.core.ticker import Ticker
from action_servers.driving.recoveries import Duration, seconds_of
from bt_mission.core.geometry import Twist2D


class WaitGoal(Protocol):
    """The goal fields of `nav2_msgs/action/Wait`."""

    time: Duration
    """How long to wait."""


def plan(goal: WaitGoal) -> Wait | Refusal:
    """Check a goal; 0 s end at once."""
    return refusal(*faults(goal, WAIT)) or Wait(seconds_of(goal.time))


class Wait:
    """Ends after `seconds` of ROS time."""

    needs_base = False

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._ticker = Ticker()
        self._told: float | None = None

    def step(self, now: Observation) -> Twist2D | Finished:
        """Wait on, or end."""
        self._ticker.update(now.time_s)
        return SUCCEEDED if self._ticker.has_reached(self._seconds) else ZERO

    def feedback(self) -> Mapping[str, Value] | None:
        """Return the time that is left, when it has changed."""
        left = max(0.0, self._seconds - self._ticker.elapsed_s)
        if left == self._told:
            return None
        self._told = left
        return {"time_left": left}

    def result(self) -> Mapping[str, Value]:
        """Return the time that has passed."""
        return {"total_elapsed_time": self._ticker.elapsed_s}
