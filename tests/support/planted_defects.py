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
from action_servers.driving.turn import Rotation, Turn
from action_servers.navigation.follower import Follower
from action_servers.navigation.surroundings import Surroundings
from action_servers.navigation.waypoints import FollowWaypoints
from bt_mission.behaviours.decorators import Repeat
from bt_mission.core.geometry import Twist2D
from bt_mission.goals.attempt import Attempt
from tests.support.planting import (
    Defect,
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
    twist,
)

DEFECTS = (
    # ---- turning --------------------------------------------------------------------------
    Defect(
        "turns with a wrong sign",
        "square",
        "turns to the left",
        altered(Turn, "step", twist(lambda twist: Twist2D(twist.linear, -twist.angular))),
    ),
    Defect(
        "stops a turn 15 degrees early",
        "square",
        "ends where it began",
        lambda patch: (
            patch.setattr(turn, "ARRIVED_WITHIN", math.radians(15)),
            patch.setattr(Turn, "step", satisfied(Turn.step)),
        ),
    ),
    Defect(
        "turns a tenth too far",
        "square",
        "ends where it began",
        given(Turn, "__init__", lambda angle, *rest: (1.1 * angle, *rest)),
    ),
    Defect(
        "turns at full speed",
        "square",
        "turns gently",
        given(Turn, "__init__", lambda angle, _, *rest: (angle, 1.8, *rest)),
    ),
    Defect(
        "drives on while it turns",
        "square",
        "turns on the spot",
        altered(Turn, "step", twist(lambda twist: Twist2D(0.05, twist.angular))),
    ),
    Defect(
        "does not look for room to turn",
        "tight_turn",
        "has room while it turns",
        instead(Room, "allow", lambda _, wanted, __: (wanted, "")),
    ),
    # ---- driving --------------------------------------------------------------------------
    Defect(
        "drives a little to the left",
        "square",
        "drives straight",
        altered(ExploreForward, "step", twist(lambda twist: Twist2D(twist.linear, 0.15))),
    ),
    Defect(
        "drives backwards",
        "square",
        "drives ahead",
        altered(ExploreForward, "step", twist(lambda twist: Twist2D(-twist.linear, 0.0))),
    ),
    Defect(
        "drives faster than it was told",
        "square",
        "keeps to its speed",
        given(ExploreForward, "__init__", lambda speed, *rest: (1.3 * speed, *rest)),
    ),
    Defect(
        "counts half of its way",
        "square",
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
    Defect(
        "stops 0.3 m late",
        "obstacle_appears",
        "stays 0.1 m away",
        given(ExploreForward, "__init__", lambda speed, gap, *rest: (speed, gap - 0.35, *rest)),
    ),
    Defect(
        "does not slow down before an obstacle",
        "obstacle_appears",
        "stays 0.1 m away",
        lambda patch: (
            patch.setattr(Drive, "speed_ahead", lambda _, now, remaining, most: most),
            patch.setattr(explore_forward.ExploreForward, "_gap", lambda self: gap(self) + 0.3),
        ),
    ),
    Defect(
        "looks at its first scan alone",
        "obstacle_appears",
        "stays 0.1 m away",
        instead(ExploreForward, "_look", first_scan_only),
    ),
    Defect("drives on blind", "scan_lost", "stands before it is blind for a second", blind),
    Defect(
        "is not held while the scan is old",
        "scan_lost",
        "stands before it is blind for a second",
        instead(governor, "stale", lambda *_: None),
    ),
    Defect("drives on without odometry", "odometry_lost", "stops when lost", blind),
    Defect(
        "commands no zero when a goal ends",
        "limits",
        "goes no farther",
        instead(pilot.Pilot, "_end", no_zero_at_the_end),
    ),
    # ---- backing up -----------------------------------------------------------------------
    Defect(
        "backs up without a look behind",
        "back_up",
        "is never hit",
        instead(Room, "allow", lambda _, wanted, __: (wanted, "")),
    ),
    Defect(
        "backs up with a wrong sign",
        "back_up",
        "backs up",
        altered(Straight, "step", twist(lambda twist: Twist2D(-twist.linear, twist.angular))),
    ),
    Defect(
        "backs up too far",
        "back_up",
        "backs up no farther than it was told",
        given(Straight, "__init__", lambda distance, *rest: (1.1 * distance, *rest)),
    ),
    Defect(
        "stops backing up early",
        "back_up",
        "backs up as far as it was told",
        instead(straight, "ARRIVED_WITHIN", 0.05),
    ),
    # ---- pictures -------------------------------------------------------------------------
    Defect(
        "sweeps to the right",
        "sweep",
        "turns to the left",
        altered(CameraSweep, "step", twist(lambda twist: Twist2D(twist.linear, -twist.angular))),
    ),
    Defect(
        "takes a picture less",
        "sweep",
        "takes every picture",
        given(CameraSweep, "__init__", lambda angle, count, *rest: (angle, count - 1, *rest)),
    ),
    Defect(
        "sweeps three quarters of the angle",
        "sweep",
        "turns half round",
        given(CameraSweep, "__init__", lambda angle, *rest: (0.75 * angle, *rest)),
    ),
    Defect(
        "sweeps too fast",
        "sweep",
        "turns slowly enough for sharp pictures",
        altered(Rotation, "towards", twist(lambda twist: Twist2D(0.0, 4.0 * twist.angular))),
    ),
    # ---- navigation -----------------------------------------------------------------------
    Defect(
        "skips a waypoint",
        "patrol",
        "comes to B before C",
        instead(FollowWaypoints, "_last_leg", skip),
    ),
    Defect(
        "visits the waypoints backwards",
        "patrol",
        "comes to A before B",
        given(FollowWaypoints, "__init__", lambda poses, *rest: (poses[::-1], *rest)),
    ),
    Defect(
        "counts as there half a metre away",
        "patrol",
        "stands in D as it was told",
        altered(
            Follower,
            "steer",
            lambda answer, self, *_: None if self.remaining < 0.6 else answer,
        ),
    ),
    Defect(
        "does not turn to the yaw of a pose",
        "patrol",
        "stands in D as it was told",
        altered(Follower, "steer", lambda answer, self, *_: answer if self.remaining else None),
    ),
    Defect(
        "takes the robot for a point",
        "patrol",
        "stays 0.2 m away",
        altered(
            Surroundings,
            "__init__",
            lambda _, self, *__: setattr(
                self, "cost", replace(self.cost, radius=0.02, comfort=0.05, margin=0.005)
            ),
        ),
    ),
    # ---- missions -------------------------------------------------------------------------
    Defect(
        "loses requests to cancel",
        "limits",
        "ends at its distance",
        instead(pilot.Pilot, "cancel", lost_cancel),
    ),
    Defect(
        "minds a condition three steps late",
        "square",
        "ends a side where it must",
        instead(Attempt, "_check_feedback", late_condition),
    ),
    Defect(
        "minds a timeout a second late",
        "limits",
        "ends at its time",
        instead(Attempt, "_check_limits", late_limits),
    ),
    Defect(
        "forgets timeouts",
        "limits",
        "ends at its time",
        instead(Attempt, "_check_limits", lambda *_: None),
    ),
    Defect(
        "repeats once less",
        "square",
        "ends where it began",
        altered(
            Repeat,
            "update",
            lambda status, self: Status.SUCCESS if self._done == 3 else status,
        ),
    ),
)
