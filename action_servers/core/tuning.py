"""Limits, tolerances and rates of the maneuvers that are a choice.

Each is a ROS parameter of the servers' node; a goal keeps the values of its arrival. Values of the
robot's build are in its model, and values of one goal are fields of the goal.
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
    image_timeout: float = number(
        2.0, (0.1, 60.0), "How long a picture is waited for, s; twenty of a camera at 10 Hz."
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
    side_margin: float = number(
        0.02,
        (0.0, 0.5),
        "Added to each side of the width in which explore_forward looks for what it stops at, m; "
        "twice the precision of an LDS-01 (10 mm, ROBOTIS e-manual).",
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
    turn_tolerance: float = number(
        1.0, (0.1, 10.0), "Error with which a rotation counts as done once the robot stands, deg."
    )
    turn_limit: float = number(
        3600.0, (1.0, 36000.0), "Largest angle of turn and spin that is accepted, deg; ten turns."
    )
    distance_limit: float = number(
        100.0, (0.1, 10000.0), "Longest way of back_up and drive_on_heading that is accepted, m."
    )
    joint_tolerance: float = number(
        0.03,
        (0.001, 1.0),
        "Error of a joint at the end of a trajectory that names none, rad or m.",
    )
    joint_time_tolerance: float = number(
        1.0,
        (0.0, 60.0),
        "Time for that after the end of a trajectory whose goal_time_tolerance is 0, s.",
    )
    duration_limit: int = number(
        3600, (1, 86400), "Longest time of move and record_distance that is accepted, s."
    )
    explore_nearest: float = number(
        0.05,
        (0.01, 1.0),
        "Shortest stopping distance that is accepted, m; five times a ray's noise. It is at least "
        "stop_margin and 0.02 m.",
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
    sweep_velocity: float = number(
        0.2,
        (0.05, 3.0),
        "Speed of a camera sweep, rad/s: slow enough for sharp pictures (the Sheffield course's).",
    )
    sweep_images: int = number(
        30, (1, 1000), "Most pictures of one camera sweep (the Sheffield course's limit)."
    )
    spin_velocity: float = number(
        1.0, (0.05, 3.0), "Speed of spin, rad/s; the fastest of Nav2's (0.4 to 1.0)."
    )
    pictures: int = number(
        60, (1, 600), "Most pictures of one goal of take_pictures; they are kept in memory."
    )
    picture_quality: int = number(90, (1, 95), "Quality of JPEG pictures, as Pillow counts it.")
    colour_share: float = number(
        0.01, (0.0001, 1.0), "Share of the picture that find_colour looks for by default."
    )
    side_goals: int = number(
        8,
        (1, 100),
        "Most goals at a time that do not drive: pictures, distances, waiting.",
        is_fixed=True,
    )


TUNING = Tuning()
"""The defaults."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NavigationTuning:
    """Of navigation: the servers' parameters `navigation.*`. Angles in rad."""

    blind_after: float = number(
        0.5,
        (0.1, 10.0),
        "Age of a scan or pose at which the robot stops, s: five scans of a Waffle, ten poses.",
    )
    give_up_after: float = number(
        3.0, (0.2, 60.0), "Age of a scan or pose at which the goal is given up, s."
    )
    wait: float = number(
        1.0,
        (0.1, 60.0),
        "How long the robot waits for what is in its way to leave, before it plans around it, s.",
    )
    recover_after: float = number(
        5.0,
        (0.5, 600.0),
        "How long it gets nowhere before it forgets what it saw, looks again and plans afresh, s.",
    )
    patience: float = number(
        10.0,
        (1.0, 3600.0),
        "How long it gets nowhere before it gives up, s (that of Nav2's progress checker).",
    )
    obstacle_memory: float = number(
        60.0,
        (1.0, 3600.0),
        "How long an obstacle that the map does not have is remembered out of sight, s.",
    )
    margin: float = number(
        0.01,
        (0.0, 0.5),
        "Kept on top of the robot's turning circle, for what a follower strays from its path, m.",
    )
    comfort: float = number(
        0.25, (0.0, 2.0), "Clearance beyond the necessary from which more is of no use, m."
    )
    goal_distance: float = number(
        0.10,
        (0.0, 1.0),
        "How far beside the goal a path may end when the robot does not fit at the goal itself, m.",
    )
    start_reach: float = number(
        0.50,
        (0.1, 2.0),
        "How far from the robot a path may begin when it stands closer than it should, m.",
    )
    arrival_distance: float = number(
        0.01, (0.001, 0.2), "The drive ends this far before the end of the path, m."
    )
    arrival_angle: float = number(
        0.02, (0.005, 3.2), "The last turn ends this close to the goal's yaw, rad."
    )
    passing_distance: float = number(
        0.4,
        (0.05, 5.0),
        "Distance to a pose of navigate_through_poses, except the last, at which the robot "
        "continues to the next, m.",
    )
    stop_on_failure: bool = number(
        True,
        (0, 1),
        "Whether follow_waypoints ends at the first pose that is not reached (Nav2's default), "
        "or continues, and reports the missed poses at the end.",
    )


NAVIGATION = NavigationTuning()
"""The defaults."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FrontierTuning:
    """Of explore_frontiers: the servers' parameters `frontiers.*`."""

    min_length: float = number(
        0.4,
        (0.05, 100.0),
        "Length of the shortest frontier worth a visit where a goal says 0, m: a Waffle passes "
        "where 0.5 m is free, and a cell on either side is the seam of the wall.",
    )
    map_wait: float = number(
        5.0,
        (0.5, 600.0),
        "How long it waits for a map, and for the robot's place on it, before it gives up, s.",
    )
    settle: float = number(
        2.5,
        (0.5, 60.0),
        "How long it stands and looks before it believes what the map says of frontiers, s: the "
        "map comes once a second, and a cell is free when two scans say so.",
    )


FRONTIERS = FrontierTuning()
"""The defaults."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MapperTuning:
    """The parameters of the mapper."""

    update_period: float = number(
        0.2,
        (0.05, 2.0),
        "How often a scan is added, s: every scan of an LDS-01, every other one of a Waffle in "
        "simulation.",
        is_fixed=True,
    )
    updates_per_map: int = number(
        5, (1, 100), "Updates from one map to the next; with the default period, one a second."
    )
