"""Whether the robot still sees, knows where it is, and gets anywhere; and codes that say so."""

from __future__ import annotations

from collections import deque
from enum import IntEnum

from action_servers.core.maneuver import Finished, Observation
from action_servers.core.tuning import NAVIGATION, NavigationTuning
from bt_mission.core.geometry import Pose2D, between, distance, wrap

_MOVED_M = 0.05
_TURNED_RAD = 0.2


class Code(IntEnum):
    """`error_code` of the results of NavigateToPose and FollowWaypoints.

    The controller's codes are those of `nav2_msgs/action/FollowPath`, the planner's those of
    `ComputePathToPose`, the last two those of `FollowWaypoints`.
    """

    NONE = 0

    TF_ERROR_WHILE_DRIVING = 102
    FAILED_TO_MAKE_PROGRESS = 105
    CONTROLLER_TIMED_OUT = 107

    TF_ERROR_WHILE_PLANNING = 202
    START_OUTSIDE_MAP = 203
    GOAL_OUTSIDE_MAP = 204
    START_OCCUPIED = 205
    GOAL_OCCUPIED = 206
    NO_VALID_PATH = 208

    WAYPOINTS_UNKNOWN = 600


class Senses:
    """Watches the age of pose and scan, from the first step of a goal on."""

    def __init__(self, start_s: float, tuning: NavigationTuning = NAVIGATION) -> None:
        self._tuning = tuning
        self._pose_s = start_s
        self._scan_s = start_s

    def check(self, now: Observation, seen_s: float | None, *, driving: bool) -> Finished | bool:
        """Return True when all is well, False to stand still, or how the goal ends.

        `seen_s` is the stamp of the newest scan that found its place on the map. `driving` tells
        which of the codes for a lost pose fits: the controller's or the planner's.
        """
        pose_ok = now.map_pose is not None and self._recent(now.odom_stamp_s, now.time_s)
        scan_ok = seen_s is not None and self._recent(seen_s, now.time_s)
        if pose_ok:
            self._pose_s = now.time_s
        if scan_ok:
            self._scan_s = now.time_s
        lost_s = now.time_s - self._pose_s
        if lost_s > self._tuning.give_up_after:
            code = Code.TF_ERROR_WHILE_DRIVING if driving else Code.TF_ERROR_WHILE_PLANNING
            return Finished("aborted", code, self._text("pose of the robot on the map", lost_s))
        blind_s = now.time_s - self._scan_s
        if blind_s > self._tuning.give_up_after:
            return Finished("aborted", Code.CONTROLLER_TIMED_OUT, self._text("scan", blind_s))
        return pose_ok and scan_ok

    def _recent(self, stamp_s: float, time_s: float) -> bool:
        return abs(time_s - stamp_s) <= self._tuning.blind_after

    def _text(self, what: str, seconds: float) -> str:
        return (
            f"no {what} with a stamp less than {self._tuning.blind_after:g} s from now for "
            f"{seconds:.1f} s; is the robot running, and do the clocks agree?"
        )


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
            or abs(wrap(pose.yaw - anchor.yaw)) > _TURNED_RAD
        ):
            self._anchor, self._since_s = pose, time_s
        return time_s - self._since_s

    def restart(self) -> None:
        """Begin to measure anew."""
        self._anchor = None


_HISTORY_S = 1.0
_GUESS_S = 0.15


class PoseHistory:
    """The poses of the last second, to place a scan by its stamp.

    A robot that turns at 1 rad/s would otherwise smear a wall 2 m away over 0.2 m between two
    scans.
    """

    def __init__(self) -> None:
        self._poses: deque[tuple[float, Pose2D]] = deque()

    def remember(self, stamp_s: float, pose: Pose2D) -> None:
        """Take in the newest pose."""
        poses = self._poses
        # Older than the last means that the clock was set back; as old, that only the correction of
        # the map frame is new.
        while poses and poses[-1][0] >= stamp_s:
            poses.pop()
        poses.append((stamp_s, pose))
        while poses[0][0] < stamp_s - _HISTORY_S:
            poses.popleft()

    def at(self, stamp_s: float) -> Pose2D | None:
        """Return the pose at a time, or None when it was too long ago or is yet to come."""
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
