"""Every `error_code` of a result: one list, and how families of actions number the same reasons."""

from __future__ import annotations

from dataclasses import astuple, dataclass
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


SPIN = Codes(unknown=700, timeout=701, tf_error=702, collision_ahead=703)
BACK_UP = Codes(unknown=710, timeout=711, tf_error=712, invalid_input=713, collision_ahead=714)
DRIVE_ON_HEADING = Codes(
    unknown=720, timeout=721, tf_error=722, collision_ahead=723, invalid_input=724
)

NAVIGATION = (
    ErrorCode.TF_ERROR_WHILE_DRIVING,
    ErrorCode.FAILED_TO_MAKE_PROGRESS,
    ErrorCode.CONTROLLER_TIMED_OUT,
    ErrorCode.TF_ERROR_WHILE_PLANNING,
    ErrorCode.START_OUTSIDE_MAP,
    ErrorCode.GOAL_OUTSIDE_MAP,
    ErrorCode.START_OCCUPIED,
    ErrorCode.GOAL_OCCUPIED,
    ErrorCode.NO_VALID_PATH,
)
"""The codes of Nav2's planner and controller with which a drive on the map ends."""

OURS = {
    ErrorCode.TF_ERROR_WHILE_DRIVING: ErrorCode.NO_MAP,
    ErrorCode.TF_ERROR_WHILE_PLANNING: ErrorCode.NO_MAP,
    ErrorCode.CONTROLLER_TIMED_OUT: ErrorCode.NO_SCAN,
}
"""The codes of missing senses of a drive on the map, as `explore_frontiers` numbers them."""
