"""The pose of the robot a moment ago."""

from __future__ import annotations

from collections import deque

from bt_mission.base.geometry import Pose2D, between

_HISTORY_S = 1.0
_GUESS_S = 0.15


class PoseHistory:
    """The poses of the last second, to place a scan by its stamp.

    Without it, a robot that turns at 1 rad/s would smear a wall 2 m away over 0.2 m between two
    scans.
    """

    def __init__(self) -> None:
        self._poses: deque[tuple[float, Pose2D]] = deque()

    def remember(self, stamp_s: float, pose: Pose2D) -> None:
        """Take in the newest pose."""
        poses = self._poses
        # A stamp older than the last means that the clock was set back; an equal one, that only the
        # correction of the map frame is new.
        while poses and poses[-1][0] >= stamp_s:
            poses.pop()
        poses.append((stamp_s, pose))
        while poses[0][0] < stamp_s - _HISTORY_S:
            poses.popleft()

    def at(self, stamp_s: float) -> Pose2D | None:
        """Return the pose at a time, or None if it is too old or in the future."""
        poses = self._poses
        if not poses or stamp_s < poses[0][0] - _GUESS_S or stamp_s > poses[-1][0] + _GUESS_S:
            return None
        later = next((index for index, (at, _) in enumerate(poses) if at >= stamp_s), None)
        if later is None:
            return poses[-1][1]
        if later == 0:
            return poses[0][1]
        (before_s, before), (after_s, after) = poses[later - 1], poses[later]
        return between(before, after, (stamp_s - before_s) / (after_s - before_s))
