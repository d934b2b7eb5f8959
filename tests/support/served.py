"""Every action that we serve: what it needs, a sound goal, and numbers that are not."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from bt_mission_interfaces.action import (
    CameraSweep,
    ExploreForward,
    ExploreFrontiers,
    FindColour,
    Move,
    RecordDistance,
    TakePictures,
    Turn,
)
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import Point
from nav2_msgs.action import (
    BackUp,
    DriveOnHeading,
    FollowWaypoints,
    NavigateThroughPoses,
    NavigateToPose,
    Spin,
    Wait,
)

from action_servers.camera.camera_sweep import CameraSweep as CameraSweepManeuver
from action_servers.camera.find_colour import FindColour as FindColourManeuver
from action_servers.camera.take_pictures import TakePictures as TakePicturesManeuver
from action_servers.driving.explore_forward import ExploreForward as ExploreForwardManeuver
from action_servers.driving.move import Move as MoveManeuver
from action_servers.driving.record_distance import RecordDistance as RecordDistanceManeuver
from action_servers.driving.recoveries import WaitManeuver
from action_servers.driving.straight import Straight
from action_servers.driving.turn import Spin as SpinManeuver
from action_servers.driving.turn import Turn as TurnManeuver
from action_servers.mapping.explore import ExploreFrontiers as ExploreFrontiersManeuver
from action_servers.navigation.navigate import NavigateToPose as NavigateToPoseManeuver
from action_servers.navigation.through_poses import (
    NavigateThroughPoses as NavigateThroughPosesManeuver,
)
from action_servers.navigation.waypoints import FollowWaypoints as FollowWaypointsManeuver
from tests.support.robot_node import pose

HUGE = 3.0e38
NOT_FINITE = (math.nan, math.inf, -math.inf)
NO_SPEED = (*NOT_FINITE, 0.27, -0.27, HUGE, -HUGE)
LEAST, MOST = -(2**31), 2**31 - 1
NEGATIVE = Duration(sec=-1)


@dataclass(frozen=True)
class Served:
    """One action; `goal` takes several seconds, `bad` has values of fields that are rejected.

    `watches` are the topics whose silence ends a goal, `asks` those without which none is accepted.
    """

    type: Any
    maneuver: Any
    goal: dict[str, Any]
    bad: dict[str, tuple[Any, ...]] = field(default_factory=dict)
    drives: bool = True
    watches: tuple[str, ...] = ("scan", "odom")
    asks: tuple[str, ...] = ("scan", "odom")


def _along(*values: float) -> tuple[Point, ...]:
    return tuple(Point(x=value) for value in values)


STRAIGHT_BAD = {
    "target": (*_along(*NOT_FINITE, 101.0, HUGE, -HUGE), Point(x=1.0, y=math.nan)),
    "speed": NO_SPEED,
    "time_allowance": (NEGATIVE,),
}

SERVED: dict[str, Served] = {
    "explore_forward": Served(
        ExploreForward,
        ExploreForwardManeuver,
        {"fwd_velocity": 0.2, "stopping_distance": 0.5},
        {
            "fwd_velocity": (*NOT_FINITE, 0.0, -0.2, 0.3, HUGE, -HUGE),
            "stopping_distance": (*NOT_FINITE, 0.0, -0.5, HUGE, -HUGE),
        },
    ),
    "turn": Served(
        Turn,
        TurnManeuver,
        {"angle": 720.0},
        {
            "angle": (*NOT_FINITE, HUGE, -HUGE),
            "angular_velocity": (*NOT_FINITE, -1.0, 1.9, HUGE, -HUGE),
        },
    ),
    "camera_sweep": Served(
        CameraSweep,
        CameraSweepManeuver,
        {"sweep_angle": 180.0, "image_count": 6},
        {
            "sweep_angle": (*NOT_FINITE, 0.0, -90.0, 181.0, HUGE, -HUGE),
            "image_count": (0, -1, 31, MOST, LEAST),
        },
        watches=("scan", "odom", "camera"),
    ),
    "move": Served(
        Move,
        MoveManeuver,
        {"secs": 10, "linear_velocity": 0.1},
        {
            "secs": (0, -1, 3601, MOST, LEAST),
            "linear_velocity": NO_SPEED,
            "angular_velocity": (*NOT_FINITE, 1.9, -1.9, HUGE, -HUGE),
        },
    ),
    "navigate_to_pose": Served(NavigateToPose, NavigateToPoseManeuver, {"pose": pose(1.5, 0.0)}),
    "navigate_through_poses": Served(
        NavigateThroughPoses,
        NavigateThroughPosesManeuver,
        {"poses": [pose(1.0, 0.0), pose(1.5, 0.5)]},
    ),
    "follow_waypoints": Served(
        FollowWaypoints,
        FollowWaypointsManeuver,
        {"poses": [pose(1.0, 0.0), pose(1.5, 0.5)]},
    ),
    "explore_frontiers": Served(
        ExploreFrontiers,
        ExploreFrontiersManeuver,
        {"min_frontier": 0.5},
        {
            "max_duration": (*NOT_FINITE, -1.0, HUGE, -HUGE),
            "min_frontier": (*NOT_FINITE, -1.0, HUGE, -HUGE),
        },
        asks=(),
    ),
    "spin": Served(
        Spin,
        SpinManeuver,
        {"target_yaw": 12.0},
        {"target_yaw": (*NOT_FINITE, HUGE, -HUGE), "time_allowance": (NEGATIVE,)},
    ),
    "backup": Served(BackUp, Straight, {"target": Point(x=1.5), "speed": 0.15}, STRAIGHT_BAD),
    "drive_on_heading": Served(
        DriveOnHeading, Straight, {"target": Point(x=1.5), "speed": 0.15}, STRAIGHT_BAD
    ),
    "record_distance": Served(
        RecordDistance,
        RecordDistanceManeuver,
        {"seconds": 10},
        {"seconds": (0, -1, 3601, MOST, LEAST)},
        drives=False,
        watches=("odom",),
        asks=("odom",),
    ),
    "take_pictures": Served(
        TakePictures,
        TakePicturesManeuver,
        {"nseconds": 10},
        {"nseconds": (0, -1, 61, MOST, LEAST)},
        drives=False,
        watches=("camera",),
        asks=(),
    ),
    "find_colour": Served(
        FindColour,
        FindColourManeuver,
        {"colour": "blue"},
        {
            "colour": ("", "bleu", "x" * 10_000),
            "min_share": (*NOT_FINITE, -0.1, 1.1, HUGE, -HUGE),
        },
        drives=False,
        watches=("camera",),
        asks=(),
    ),
    "wait": Served(
        Wait,
        WaitManeuver,
        {"time": Duration(sec=10)},
        {"time": (NEGATIVE, Duration(sec=LEAST))},
        drives=False,
        watches=(),
        asks=(),
    ),
}
DRIVING = [name for name, one in SERVED.items() if one.drives]
BESIDE = [name for name, one in SERVED.items() if not one.drives]


def goal(name: str, **changes: Any) -> Any:
    """A sound goal of an action that takes several seconds, with changes."""
    return SERVED[name].type.Goal(**(SERVED[name].goal | changes))
