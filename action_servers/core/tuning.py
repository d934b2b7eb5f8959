"""Limits, tolerances and rates of all maneuvers that are a choice.

Each is a ROS parameter of the servers' node; a goal keeps the values of its arrival. Values of the
robot's build are in its model, and values of one goal are fields of the goal. What only some
actions have is in a dataclass beside them, the `tuning` of their declarations.
"""

from __future__ import annotations

from dataclasses import dataclass

from bt_mission.base.parameters import number


@dataclass(frozen=True, slots=True, kw_only=True)
class Tuning:
    """Of all maneuvers. Times are in s of ROS time, lengths in m, angles in deg."""

    sensor_timeout: float = number(
        1.0,
        (0.2, 10.0),
        "Age at which a scan or odometry is no longer trusted, s. The default is five turns of the "
        "slowest lidar of a TurtleBot3 (LDS-01, 5 Hz), twenty messages of its odometry.",
    )
    hold_after: float = number(
        0.6,
        (0.2, 10.0),
        "Age of a scan or odometry at which the base is held until there is a newer one, s: three "
        "turns of an LDS-01. With the 0.26 s of braking from full speed, it stands within 1 s.",
    )
    blocked_after: float = number(
        2.0, (0.5, 60.0), "Time without progress after which a maneuver gives up, s."
    )
    settle_limit: float = number(
        1.0,
        (0.0, 10.0),
        "Time after a command to stop, after which the base counts as standing, s.",
    )
    rest_linear: float = number(
        0.01, (0.001, 0.1), "Speed below which the base counts as standing, m/s."
    )
    rest_angular: float = number(
        0.02, (0.001, 0.5), "Turning speed below which the base counts as standing, rad/s."
    )
    stop_margin: float = number(
        0.03,
        (0.01, 0.5),
        "Gap that every maneuver keeps to obstacles, m; three standard deviations of a "
        "lidar's ray.",
    )
    turn_margin: float = number(
        3.0,
        (0.5, 45.0),
        "Rotation that is kept free before the hull would meet an obstacle, whatever turns, deg.",
    )
    duration_limit: int = number(
        3600, (1, 86400), "Longest time of a goal that lasts as long as it says, s."
    )
    give_way_time: float = number(
        2.5,
        (0.0, 10.0),
        "Time before something that moves would touch the robot at which it gives way, s; 0: it "
        "never does. A Waffle needs 2 s to get its own width aside.",
    )
    give_way_distance: float = number(
        1.0,
        (0.0, 10.0),
        "How far one goal's robot gets out of the way of what moves, m; then it stands still.",
    )
    side_goals: int = number(
        8,
        (1, 100),
        "Most goals at a time that do not drive: pictures, distances, waiting.",
        is_fixed=True,
    )


TUNING = Tuning()
"""The defaults."""
