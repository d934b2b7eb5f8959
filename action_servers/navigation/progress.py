"""Whether the robot gets anywhere."""

from __future__ import annotations

from action_servers.core.geometry import distance, wrapped
from action_servers.core.maneuver import Pose2D

_MOVED_M = 0.05
_TURNED_RAD = 0.2


class ProgressChecker:
    """Measures for how long the robot has stayed where it is."""

    def __init__(self) -> None:
        self._anchor: Pose2D | None = None
        self._since_s = 0.0

    def standing_s(self, pose: Pose2D, time_s: float) -> float:
        """Return for how many seconds the robot has moved less than 0.05 m and 0.2 rad."""
        anchor = self._anchor
        if (
            anchor is None
            or distance(anchor, pose) > _MOVED_M
            or abs(wrapped(pose.yaw - anchor.yaw)) > _TURNED_RAD
        ):
            self._anchor, self._since_s = pose, time_s
        return time_s - self._since_s

    def restart(self) -> None:
        """Begin to measure anew."""
        self._anchor = None
