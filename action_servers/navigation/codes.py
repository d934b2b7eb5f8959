"""Error codes of Nav2 for ROS 2 Jazzy that navigation passes on (`nav2_msgs` 1.3)."""

from __future__ import annotations

from enum import IntEnum


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
