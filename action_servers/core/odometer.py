"""How far the base has driven and turned since a goal began."""

from __future__ import annotations

import math
from dataclasses import dataclass

from action_servers.core.maneuver import Observation
from bt_mission.core.geometry import Pose2D


@dataclass(slots=True)
class Odometer:
    """Adds up odometry poses.

    `max_linear` (m/s) and `max_angular` (rad/s) are the limits of the robot: a step between two
    poses that would need more than twice as much is a jump (odometry was reset), no motion.

    `distance` is the length of the path in metres; `yaw` is the rotation in radians, left
    positive and not wrapped, so that two turns are 4 pi.
    """

    max_linear: float
    max_angular: float
    distance: float = 0.0
    yaw: float = 0.0
    _last: Pose2D | None = None
    _stamp_s: float = 0.0

    def update(self, now: Observation) -> str | None:
        """Take in the newest pose; return what is wrong with it, or None."""
        pose = now.odom
        if pose is None or (self._last is not None and now.odom_stamp_s == self._stamp_s):
            return None
        last, self._last = self._last, pose
        elapsed = now.odom_stamp_s - self._stamp_s
        self._stamp_s = now.odom_stamp_s
        if last is None:
            return None
        moved = math.hypot(pose.x - last.x, pose.y - last.y)
        turned = math.remainder(pose.yaw - last.yaw, math.tau)
        if moved > 2.0 * self.max_linear * elapsed + 0.05:
            return f"odometry jumped by {moved:.2f} m in {elapsed:.3f} s; was it reset?"
        if abs(turned) > 2.0 * self.max_angular * elapsed + 0.1:
            degrees = math.degrees(turned)
            return f"odometry jumped by {degrees:.0f} deg in {elapsed:.3f} s; was it reset?"
        self.distance += moved
        self.yaw += turned
        return None
