"""The parameters of navigation: how long it waits, and what it keeps clear of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from bt_mission.base.parameters import number


@dataclass(frozen=True, slots=True, kw_only=True)
class NavigationTuning:
    """Of all that drives on a map: the servers' parameters `navigation.*`. Angles in rad."""

    PREFIX: ClassVar = "navigation."

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
