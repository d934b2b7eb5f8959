"""What goals may hold: one declaration for each action, by which the servers refuse a goal.

The servers ask it when a goal comes, and `bt-mission check` asks it before anything moves. So it
needs neither ROS nor NumPy. What depends on the moment, such as a missing scan, is not here.
"""

from __future__ import annotations

import math
from typing import Any

from action_servers.core.limits import ColourLimit, Limits, NumberLimit
from action_servers.core.tuning import Tuning
from bt_mission.core.robot.model import RobotModel

SLOWEST_TURN = 0.05
"""rad/s: the lowest rate that is accepted, and the one at which the last of a turn is made."""

SLOWEST_DRIVE = 0.01
"""m/s: the lowest speed that is accepted, and the one of the last millimetres."""

WIDEST_SWEEP_DEG = 180.0
"""The limit of the Sheffield course's camera sweep for Jazzy, whose missions run here too."""

SMALLEST_SHARE = 1e-4
"""Eight pixels of a picture of 320 x 240: less is no patch."""

MOST_POSES = 1_000
"""Poses of a goal: each is checked and placed on the map between two control steps."""

LEAST_MIN_FRONTIER_M = 0.05
"""One cell of a map of the usual resolution, m."""

MOST_MIN_FRONTIER_M = 100.0
LONGEST_EXPLORATION_S = 86_400.0


def turn_limits(robot: RobotModel, tuning: Tuning) -> Limits:
    """Return the limits of `turn`. An angle of 0 succeeds without moving."""
    angle, fastest = tuning.turn_limit, robot.max_angular_velocity
    return (
        NumberLimit(
            field="angle", low=-angle, high=angle, unit="deg", source=_parameter("turn_limit")
        ),
        NumberLimit(
            field="angular_velocity",
            low=SLOWEST_TURN,
            high=fastest,
            unit="rad/s",
            source=ANGULAR,
            zero="the server's default",
        ),
    )


def spin_limits(tuning: Tuning) -> Limits:
    """Return the limits of `spin`."""
    angle = math.radians(tuning.turn_limit)
    source = _parameter("turn_limit")
    return (
        NumberLimit(field="target_yaw", low=-angle, high=angle, unit="rad", source=source),
        ALLOWANCE,
    )


def move_limits(robot: RobotModel, tuning: Tuning) -> Limits:
    """Return the limits of `move`."""
    fastest, sharpest = robot.max_linear_velocity, robot.max_angular_velocity
    return (
        _duration_limit("secs", tuning),
        NumberLimit(field="linear_velocity", low=-fastest, high=fastest, unit="m/s", source=LINEAR),
        NumberLimit(
            field="angular_velocity", low=-sharpest, high=sharpest, unit="rad/s", source=ANGULAR
        ),
    )


def explore_forward_limits(robot: RobotModel, tuning: Tuning) -> Limits:
    """Return the limits of `explore_forward`."""
    lidar, front = robot.lidar, robot.hull.front
    blind = lidar.min_range - (front - lidar.x)
    return (
        NumberLimit(
            field="fwd_velocity",
            low=SLOWEST_DRIVE,
            high=robot.max_linear_velocity,
            unit="m/s",
            source=LINEAR,
        ),
        NumberLimit(
            field="stopping_distance",
            low=tuning.explore_nearest + max(0.0, blind),
            high=lidar.max_range - (front - lidar.x),
            unit="m",
            source=f"{_parameter('explore_nearest')}, and the lidar of the robot",
        ),
    )


def straight_limits(robot: RobotModel, tuning: Tuning) -> Limits:
    """Return the limits of `back_up` and `drive_on_heading`."""
    fastest, longest = robot.max_linear_velocity, tuning.distance_limit
    source = _parameter("distance_limit")
    return (
        NumberLimit(field="target.x", low=-longest, high=longest, unit="m", source=source),
        NumberLimit(field="speed", low=-fastest, high=fastest, unit="m/s", source=LINEAR),
        ALLOWANCE,
    )


def straight_misfit(goal: Any, *, backwards: bool) -> str | None:
    """Return why a goal of `back_up` or `drive_on_heading` is aborted at once, or None.

    Backwards the signs of distance and speed do not matter, as with Nav2.
    """
    target, speed = goal.target, goal.speed
    if target.y != 0.0 or target.z != 0.0:
        return f"target.y and target.z must be 0, got {target.y:g} and {target.z:g}"
    if not backwards and (target.x > 0.0) != (speed > 0.0):
        return f"target.x and speed must have one sign, got {target.x:g} m and {speed:g} m/s"
    if abs(speed) < SLOWEST_DRIVE and target.x != 0.0:
        shown = -abs(speed) if backwards else speed
        return f"speed must be {SLOWEST_DRIVE:g} m/s or more, got {shown:g}"
    return None


def pose_misfit(goal: Any) -> str | None:
    """Return why a goal of `navigate_to_pose` leads nowhere, or None."""
    return None if goal.pose.header.frame_id else "the pose is missing, or its header.frame_id"


def waypoints_misfit(goal: Any) -> str | None:
    """Return why a goal of `follow_waypoints` cannot be carried out, or None."""
    if not goal.poses:
        return "the list of poses is empty"
    too_many = poses_misfit(goal)
    if too_many is not None:
        return too_many
    last = len(goal.poses) - 1
    if goal.goal_index > last:
        return f"goal_index must be from 0 to {last}, got {goal.goal_index}"
    return None


def through_poses_misfit(goal: Any) -> str | None:
    """Return why a goal of `navigate_through_poses` cannot be carried out, or None."""
    return poses_misfit(goal) if goal.poses else "poses must hold at least one pose"


def poses_misfit(goal: Any) -> str | None:
    """Return why there are too many poses in a goal, or None."""
    count = len(goal.poses)
    return None if count <= MOST_POSES else f"poses must be {MOST_POSES:,} or less, got {count:,}"


def camera_sweep_limits(tuning: Tuning) -> Limits:
    """Return the limits of `camera_sweep`."""
    return (
        NumberLimit(
            field="sweep_angle",
            low=0.0,
            high=WIDEST_SWEEP_DEG,
            unit="deg",
            source="the Sheffield course's camera sweep",
            above=True,
        ),
        NumberLimit(
            field="image_count",
            low=1,
            high=tuning.sweep_images,
            unit="images",
            source=_parameter("sweep_images"),
        ),
    )


def take_pictures_limits(tuning: Tuning) -> Limits:
    """Return the limits of `take_pictures`."""
    most, source = tuning.pictures, _parameter("pictures")
    return (NumberLimit(field="nseconds", low=1, high=most, unit="s", source=source),)


def record_distance_limits(tuning: Tuning) -> Limits:
    """Return the limits of `record_distance`."""
    return (_duration_limit("seconds", tuning),)


def _parameter(name: str) -> str:
    return f"parameter {name} of the servers"


def _duration_limit(field: str, tuning: Tuning) -> NumberLimit:
    longest, source = tuning.duration_limit, _parameter("duration_limit")
    return NumberLimit(field=field, low=1, high=longest, unit="s", source=source)


LINEAR = "max_linear_velocity of the robot"
ANGULAR = "max_angular_velocity of the robot"
_NOT_NEGATIVE = "a time is not negative"
ALLOWANCE = NumberLimit(
    field="time_allowance", low=0.0, high=math.inf, unit="s", source=_NOT_NEGATIVE
)

WAIT: Limits = (NumberLimit(field="time", low=0.0, high=math.inf, unit="s", source=_NOT_NEGATIVE),)
"""The limits of Nav2's `wait`."""

FIND_COLOUR: Limits = (
    ColourLimit("colour"),
    NumberLimit(
        field="min_share",
        low=SMALLEST_SHARE,
        high=1.0,
        unit="of the picture",
        source="what is still a patch of colour",
        zero="the server's default",
    ),
)
"""The limits of `find_colour`."""

EXPLORE_FRONTIERS: Limits = (
    NumberLimit(
        field="max_duration", low=0.0, high=LONGEST_EXPLORATION_S, unit="s", source="a day"
    ),
    NumberLimit(
        field="min_frontier",
        low=LEAST_MIN_FRONTIER_M,
        high=MOST_MIN_FRONTIER_M,
        unit="m",
        source="a cell of the map",
        zero="the server's default",
    ),
)
"""The limits of `explore_frontiers`."""
