"""Defects, and the requirements of shipped scenarios that catch them."""

from __future__ import annotations

import math
from dataclasses import replace

from py_trees.common import Status

from action_servers.camera.camera_sweep import CameraSweep
from action_servers.core import governor, pilot
from action_servers.core.governor import Room
from action_servers.driving import explore_forward, straight, turn
from action_servers.driving.drive import Drive
from action_servers.driving.explore_forward import ExploreForward
from action_servers.driving.straight import Straight
from action_servers.driving.turn import Turn
from action_servers.navigation.follower import Follower
from action_servers.navigation.surroundings import Surroundings
from action_servers.navigation.waypoints import FollowWaypoints
from bt_mission.base.geometry import Twist2D
from bt_mission.executive.behaviours.decorators import Repeat
from bt_mission.executive.goals.attempt import Attempt
from tests.support.planting import (
    Defect,
    Plant,
    altered,
    blind,
    first_scan_only,
    gap,
    given,
    instead,
    late_condition,
    late_limits,
    lost_cancel,
    no_zero_at_the_end,
    satisfied,
    skip,
    twisted,
)

GOES_ANYWHERE = instead(Room, "allow", lambda _, wanted, __: (wanted, ""))

ROWS: dict[str, tuple[tuple[str, str, Plant], ...]] = {
    "tight_turn": (("does not look for room to turn", "has room while it turns", GOES_ANYWHERE),),
    "square": (
        (
            "turns with a wrong sign",
            "turns to the left",
            twisted(Turn, lambda twist: Twist2D(twist.linear, -twist.angular)),
        ),
        (
            "stops a turn 15 degrees early",
            "ends where it began",
            lambda patch: (
                patch.setattr(turn, "ARRIVED_WITHIN", math.radians(15)),
                patch.setattr(Turn, "step", satisfied(Turn.step)),
            ),
        ),
        (
            "turns a tenth too far",
            "ends where it began",
            given(Turn, "__init__", lambda angle, *rest: (1.1 * angle, *rest)),
        ),
        (
            "turns at full speed",
            "turns gently",
            given(Turn, "__init__", lambda angle, _, *rest: (angle, 1.8, *rest)),
        ),
        (
            "drives on while it turns",
            "turns on the spot",
            twisted(Turn, lambda twist: Twist2D(0.05, twist.angular)),
        ),
        (
            "drives a little to the left",
            "drives straight",
            twisted(ExploreForward, lambda twist: Twist2D(twist.linear, 0.15)),
        ),
        (
            "drives backwards",
            "drives ahead",
            twisted(ExploreForward, lambda twist: Twist2D(-twist.linear, 0.0)),
        ),
        (
            "drives faster than it was told",
            "keeps to its speed",
            given(ExploreForward, "__init__", lambda speed, *rest: (1.3 * speed, *rest)),
        ),
        (
            "counts half of its way",
            "keeps within its square",
            altered(
                ExploreForward,
                "feedback",
                lambda feedback, *_: (
                    feedback
                    and {
                        **feedback,
                        "current_distance_travelled": feedback["current_distance_travelled"] / 2,
                    }
                ),
            ),
        ),
        (
            "minds a condition three steps late",
            "ends a side where it must",
            instead(Attempt, "_check_feedback", late_condition),
        ),
        (
            "repeats once less",
            "ends where it began",
            altered(
                Repeat, "update", lambda status, self: Status.SUCCESS if self._done == 3 else status
            ),
        ),
    ),
    "obstacle_appears": (
        (
            "stops 0.3 m late",
            "stays 0.1 m away",
            given(ExploreForward, "__init__", lambda speed, gap, *rest: (speed, gap - 0.35, *rest)),
        ),
        (
            "does not slow down before an obstacle",
            "stays 0.1 m away",
            lambda patch: (
                patch.setattr(Drive, "speed_ahead", lambda _, now, remaining, most: most),
                patch.setattr(explore_forward.ExploreForward, "_gap", lambda self: gap(self) + 0.3),
            ),
        ),
        (
            "looks at its first scan alone",
            "stays 0.1 m away",
            instead(ExploreForward, "_look", first_scan_only),
        ),
    ),
    "scan_lost": (
        ("drives on blind", "stands before it is blind for a second", blind),
        (
            "is not held while the scan is old",
            "stands before it is blind for a second",
            instead(governor, "stale", lambda *_: None),
        ),
    ),
    "odometry_lost": (("drives on without odometry", "stops when lost", blind),),
    "limits": (
        (
            "commands no zero when a goal ends",
            "goes no farther",
            instead(pilot.Pilot, "_end", no_zero_at_the_end),
        ),
        (
            "loses requests to cancel",
            "ends at its distance",
            instead(pilot.Pilot, "cancel", lost_cancel),
        ),
        (
            "minds a timeout a second late",
            "ends at its time",
            instead(Attempt, "_check_limits", late_limits),
        ),
        (
            "forgets timeouts",
            "ends at its time",
            instead(Attempt, "_check_limits", lambda *_: None),
        ),
    ),
    "back_up": (
        ("backs up without a look behind", "is never hit", GOES_ANYWHERE),
        (
            "backs up with a wrong sign",
            "backs up",
            twisted(Straight, lambda twist: Twist2D(-twist.linear, twist.angular)),
        ),
        (
            "backs up too far",
            "backs up no farther than it was told",
            given(Straight, "__init__", lambda distance, *rest: (1.1 * distance, *rest)),
        ),
        (
            "stops backing up early",
            "backs up as far as it was told",
            instead(straight, "ARRIVED_WITHIN", 0.05),
        ),
    ),
    "sweep": (
        (
            "sweeps to the right",
            "turns to the left",
            twisted(CameraSweep, lambda twist: Twist2D(twist.linear, -twist.angular)),
        ),
        (
            "takes a picture less",
            "takes every picture",
            given(CameraSweep, "__init__", lambda angle, count, *rest: (angle, count - 1, *rest)),
        ),
        (
            "sweeps three quarters of the angle",
            "turns half round",
            given(CameraSweep, "__init__", lambda angle, *rest: (0.75 * angle, *rest)),
        ),
        (
            "sweeps too fast",
            "turns slowly enough for sharp pictures",
            twisted(Drive, lambda twist: Twist2D(0.0, 4.0 * twist.angular), "turn_towards"),
        ),
    ),
    "patrol": (
        ("skips a waypoint", "comes to B before C", instead(FollowWaypoints, "_last_leg", skip)),
        (
            "visits the waypoints backwards",
            "comes to A before B",
            given(FollowWaypoints, "__init__", lambda poses, *rest: (poses[::-1], *rest)),
        ),
        (
            "counts as there half a metre away",
            "stands in D as it was told",
            altered(
                Follower, "steer", lambda answer, self, *_: None if self.remaining < 0.6 else answer
            ),
        ),
        (
            "does not turn to the yaw of a pose",
            "stands in D as it was told",
            altered(Follower, "steer", lambda answer, self, *_: answer if self.remaining else None),
        ),
        (
            "takes the robot for a point",
            "stays 0.2 m away",
            altered(
                Surroundings,
                "__init__",
                lambda _, self, *__: setattr(
                    self, "cost", replace(self.cost, radius=0.02, comfort=0.05, margin=0.005)
                ),
            ),
        ),
    ),
}
"""By scenario: what is wrong, the requirement that it violates, and what plants it."""

DEFECTS = tuple(Defect(row[0], scenario, *row[1:]) for scenario in ROWS for row in ROWS[scenario])
