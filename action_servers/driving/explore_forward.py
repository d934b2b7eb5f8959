"""Drive straight ahead until something is near."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from action_servers.core.action import Action
from action_servers.core.limits import (
    LINEAR,
    SLOWEST_DRIVE,
    UNBOUNDED,
    Limits,
    NumberLimit,
    parameter,
)
from action_servers.core.maneuver import SUCCEEDED, ZERO, Fields, Finished, Observation, Scan
from action_servers.core.progress import ChangedFields
from action_servers.core.tuning import Tuning
from action_servers.driving.drive import ARRIVED_WITHIN, Drive
from bt_mission.base.geometry import Twist2D
from bt_mission.base.parameters import number
from bt_mission.robots.model import RobotModel

if TYPE_CHECKING:
    from action_servers.core.clearance import ObstaclePoint

NEARER_M = 0.02
"""m beyond `stop_margin`: a base with a nearer stop would be held before it arrives."""

GONE_BEYOND = 0.05
"""Metres beyond the stopping distance at which an earlier obstacle has left."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ExploreTuning(Tuning):
    """Of what it stops at."""

    side_margin: float = number(
        0.02,
        (0.0, 0.5),
        "Added to each side of the width in which explore_forward looks for what it stops at, m; "
        "twice the precision of an LDS-01 (10 mm, ROBOTIS e-manual).",
    )
    explore_nearest: float = number(
        0.05,
        (0.01, 1.0),
        "Shortest stopping distance that is accepted, m; five times a ray's noise. It is at least "
        "stop_margin and 0.02 m.",
    )


EXPLORING = ExploreTuning()
"""The defaults."""


def limits(robot: RobotModel, tuning: ExploreTuning) -> Limits:
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
            low=max(tuning.explore_nearest, tuning.stop_margin + NEARER_M) + max(0.0, blind),
            high=lidar.max_range - (front - lidar.x),
            unit="m",
            source=f"{parameter('explore_nearest')}, and the lidar of the robot",
        ),
    )


def plan(
    goal: Any, _now: Observation, robot: RobotModel, tuning: ExploreTuning = EXPLORING
) -> ExploreForward:
    """Return the maneuver for a goal."""
    return ExploreForward(goal.fwd_velocity, goal.stopping_distance, robot, tuning)


class ExploreForward:
    """Drives at `speed` (m/s) until the hull is `stopping_distance` (metres) from an obstacle.

    It brakes in time to stand at that distance, and finishes once it stands. Between two scans it
    continues by odometry.
    """

    needs_base = True

    def __init__(
        self,
        speed: float,
        stopping_distance: float,
        robot: RobotModel,
        tuning: ExploreTuning = EXPLORING,
    ) -> None:
        self._speed = speed
        self._stopping_distance = stopping_distance
        self._robot = robot
        self._side_margin = tuning.side_margin
        self._drive = Drive(robot, tuning)
        self._arrived = False
        self._scan: Scan | None = None
        self._ahead: ObstaclePoint | None = None
        self._aside: ObstaclePoint | None = None
        self._distance_at_scan = 0.0
        self._changed = ChangedFields()

    def step(self, now: Observation) -> Twist2D | Finished:
        """Drive on, slow down, or end."""
        fault = self._drive.fault(now)
        if fault is not None:
            return fault
        self._look(now)
        remaining = self._gap() - self._stopping_distance
        is_near = self._arrived or remaining <= ARRIVED_WITHIN
        self._arrived = is_near and not now.gives_way
        if self._arrived:
            rest = self._drive.rest(now)
            if rest is not None:
                return rest
            if remaining <= GONE_BEYOND:
                return SUCCEEDED
            self._arrived = False  # the obstacle has left
        if remaining <= ARRIVED_WITHIN:
            return ZERO  # the obstacle approaches
        speed = self._drive.speed_ahead(now, remaining, self._speed)
        return Twist2D(speed, 0.0)

    def feedback(self) -> Fields | None:
        """Return distance driven and gap ahead, when either has changed."""
        done = self._drive.distance
        return self._changed.of(
            {"current_distance_travelled": done, "closest_obstacle": self._gap()}
        )

    def result(self) -> Fields:
        """Return distance driven, gap ahead (inf without an obstacle in view) and its bearing."""
        return {
            "total_distance_travelled": self._drive.distance,
            "closest_obstacle": self._gap(),
            "closest_obstacle_angle": self._bearing_deg(),
        }

    def _look(self, now: Observation) -> None:
        # NumPy, which `check` does not need. The servers have it loaded.
        from action_servers.core.clearance import (  # noqa: PLC0415
            ahead,
            nearest_in_front,
            obstacle_points,
        )

        scan = now.scan
        if scan is None or scan is self._scan:
            return
        self._scan = scan
        points = obstacle_points(scan, self._robot.lidar)
        self._ahead = ahead(points, self._robot.hull, self._side_margin)
        self._aside = None if self._ahead else nearest_in_front(points, self._robot.hull)
        speed = now.velocity.linear if now.velocity else 0.0
        self._distance_at_scan = self._drive.distance - speed * (now.odom_stamp_s - scan.stamp_s)

    def _gap(self) -> float:
        if self._ahead is None:
            return math.inf
        gap = self._ahead.gap - (self._drive.distance - self._distance_at_scan)
        return max(0.0, gap)

    def _bearing_deg(self) -> float:
        """Return the bearing of the obstacle ahead, else of the nearest one beside, else 0."""
        seen = self._ahead or self._aside
        if seen is None:
            return 0.0
        advance = self._drive.distance - self._distance_at_scan
        return math.degrees(math.atan2(seen.y, seen.x - advance))


EXPLORE_FORWARD = Action(
    name="explore_forward",
    type="bt_mission_interfaces/action/ExploreForward",
    needs=("base", "scan", "odometry"),
    example={"fwd_velocity": 0.2, "stopping_distance": 0.5},
    plan=plan,
    tuning=EXPLORING,
    limits=limits,
    feedback=lambda _goal: {
        "current_distance_travelled": UNBOUNDED,
        "closest_obstacle": UNBOUNDED,
    },
)
