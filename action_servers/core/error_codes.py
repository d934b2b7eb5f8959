"""The `error_code` of results: one list for all actions."""

from __future__ import annotations

from enum import IntEnum

from bt_mission.base.dds.liveliness import EXECUTIVE_LOST


class ErrorCode(IntEnum):
    """The reason of a goal's end; 0 means no error for every action.

    From 900 on those of `bt_mission_interfaces`. Those of navigation are Nav2's: 1xx of
    `nav2_msgs/action/FollowPath`, 2xx of `ComputePathToPose`, 600 of `FollowWaypoints`.
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

    UNKNOWN = 900
    STOPPED = 901
    NO_SCAN = 902
    NO_ODOMETRY = 903
    NO_IMAGE = 904
    STORAGE = 905
    BLOCKED = 906
    MOTORS_OFF = 907
    NO_MAP = 908
    EXECUTIVE_LOST = EXECUTIVE_LOST
