"""How the base gives way to what moves towards it: it brakes in time, and moves aside.

The rule is passive safety: a velocity is commanded only if the base can stand after it, and nothing
that moves on its present course touches it within a time. If standing is not safe, arcs are tried,
each against everything in the scan.

Where arcs take the hull, and when it meets what moves: many arcs at once.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from action_servers.core.clearance import (
    ESCAPE_M,
    MOVING_M,
    Footprint,
    Points,
    footprint,
    into_frame,
    obstacle_points,
)
from action_servers.core.drive_limits import DriveLimits, limits
from action_servers.core.grid import Floats
from action_servers.core.maneuver import ZERO, Observation, Scan
from action_servers.core.moving_obstacles import MovingObstacles
from action_servers.core.tuning import TUNING, Tuning
from bt_mission.base.geometry import Pose2D, Twist2D
from bt_mission.robots.model import RobotModel

STEP_S = 0.1
"""The time between two places on an arc."""


@dataclass(frozen=True, slots=True)
class MovingPoints:
    """Moving points from the base, `n x 2` m, with velocity, m/s, and turn rate, rad/s."""

    points: Points
    rates: Points
    turning: Floats

    def at(self, times: Floats) -> Floats:
        """Return the points at times from now, `times x n x 2`."""
        turned = times[:, None] * self.turning
        along = times[:, None] * np.sinc(turned / math.pi)
        aside = times[:, None] * np.sinc(turned / math.tau) * np.sin(turned / 2)
        left = np.stack([-self.rates[:, 1], self.rates[:, 0]], axis=1)
        return self.points + along[:, :, None] * self.rates + aside[:, :, None] * left


def rolled_out(
    velocity: Twist2D, arcs: Sequence[Twist2D], times: Floats, for_s: float, limits: DriveLimits
) -> Floats:
    """Return x, y and yaw of each arc at each time, `arcs x times x 3`, from the base.

    It begins at a velocity; arcs are driven for a time, s, and then the base brakes. `times` are
    `STEP_S` apart.
    """
    linear = np.full(len(arcs), velocity.linear)
    angular = np.full(len(arcs), velocity.angular)
    lateral = np.full(len(arcs), velocity.lateral)
    wanted = np.array([(arc.linear, arc.angular, arc.lateral) for arc in arcs])
    slides = velocity.lateral != 0.0 or bool(wanted[:, 2].any())
    poses = np.zeros((len(arcs), len(times), 3))
    step = limits.acceleration * STEP_S, limits.angular_acceleration * STEP_S
    for index in range(1, len(times)):
        to = wanted if times[index] <= for_s + STEP_S / 2 else np.zeros_like(wanted)
        linear = linear + np.clip(to[:, 0] - linear, -step[0], step[0])
        angular = angular + np.clip(to[:, 1] - angular, -step[1], step[1])
        x, y, yaw = poses[:, index - 1].T
        middle = yaw + 0.5 * angular * STEP_S
        poses[:, index, 0] = x + linear * np.cos(middle) * STEP_S
        poses[:, index, 1] = y + linear * np.sin(middle) * STEP_S
        poses[:, index, 2] = yaw + angular * STEP_S
        if slides:
            lateral = lateral + np.clip(to[:, 2] - lateral, -step[0], step[0])
            poses[:, index, 0] -= lateral * np.sin(middle) * STEP_S
            poses[:, index, 1] += lateral * np.cos(middle) * STEP_S
    return poses


def grown(body: Footprint, margin: float) -> Footprint:
    """Return a footprint that is larger by a margin in metres, its circle too."""
    return replace(body.grown(margin), turning_radius=body.turning_radius + margin)


def depth_in(body: Footprint, poses: Floats, points: Floats) -> Floats:
    """Return how deep points lie in the hull, m: `arcs x times x points`.

    `points` are `times x points x 2`, or `1 x points x 2` for those that stay.
    """
    yaw = poses[:, :, 2, None]
    cosine, sine = np.cos(yaw), np.sin(yaw)
    across = points[None, :, :, 0] - poses[:, :, 0, None]
    along = points[None, :, :, 1] - poses[:, :, 1, None]
    return body.depth(cosine * across + sine * along, cosine * along - sine * across)


_BEYOND_S = 2.0
"""The time after the time to give way for which an arc is judged; the base stands at its end."""
_COMMIT_S = 0.15
"""A command holds until the next scan, and one control step."""
_CALM_S = 0.5
"""How much longer than needed standing must be safe before the goal continues."""
_GAIN_S = 0.5
"""How much later a contact must come for the base to move at all."""
_ENOUGH_M = 0.2
_CLOSE_M = 0.3
"""Margins, and the distance until the base stands."""
_AGAIN_M = 0.05
_METRE_COSTS = 0.05
_DEEPER_M = 0.005
_MOST_POINTS = 24
_MOST_FIXED = 90
_BLIND_RAYS = 4
_OWN_M = 0.08
"""Points this near to a moving point move with it."""
_BLIND_M, _BLIND_RAD = 0.03, 0.05
_TOLD_WAY, _TOLD_TRAPPED = 1, 2
_STANDS_LINEAR, _STANDS_ANGULAR = 0.02, 0.05


class GiveWay:
    """Watches moving obstacles, and takes the base over while one would hit it.

    Args:
        robot: Its limits and its hull; no arc is faster.
        tuning: How early it gives way (0: never), and how far the base of one goal is moved.
    """

    def __init__(self, robot: RobotModel, tuning: Tuning = TUNING) -> None:
        self._tuning = tuning
        self._robot = robot
        self._body = footprint(robot)
        self._wide = grown(self._body, MOVING_M)
        self._near = grown(self._body, ESCAPE_M)
        self._limits = limits(robot)
        self._moving = MovingObstacles(robot.lidar)
        self._scan: Scan | None = None
        self._arc = ZERO
        self._escape: Twist2D | None = None
        self._wanted = ZERO
        self._last_s = 0.0
        self.is_active = False
        """Whether the base is taken over: the twists of maneuvers are not commanded."""
        self.way = 0.0
        """The distance that the base was moved aside since `begin`, m."""
        self.times = 0
        """The number of times that it gave way since `begin`."""
        self.is_trapped = False
        """Whether something approaches the base, and no arc helps."""
        self._noted = 0

    @property
    def summary(self) -> str:
        """Its actions for the goal, as text."""
        often = "once" if self.times == 1 else f"{self.times} times"
        return f"gave way {often} to what moved, by {self.way:.2f} m in all"

    def begin(self, tuning: Tuning) -> None:
        """Begin a goal: nothing of its limit is used up yet."""
        self._tuning = tuning
        self.is_active = self.is_trapped = False
        self.way, self.times, self._noted = 0.0, 0, 0
        self._escape, self._wanted, self._scan = None, ZERO, None

    def notes(self) -> Iterator[str]:
        """Yield new notes on this goal, each once."""
        if self.times and not self._noted & _TOLD_WAY:
            self._noted |= _TOLD_WAY
            yield "something comes at the robot: it gives way"
        if self.is_trapped and not self._noted & _TOLD_TRAPPED:
            self._noted |= _TOLD_TRAPPED
            yield "something comes at the robot, and there is no way out: it stands still"

    def look(self, now: Observation) -> bool:
        """Handle an observation; return whether the base has to leave its place."""
        horizon_s = self._tuning.give_way_time
        if not horizon_s:
            self.is_active = False
            return False
        if self.is_active and self._escape is not None:
            self.way += abs(self._arc.linear) * max(0.0, now.time_s - self._last_s)
        self._last_s = now.time_s
        self._moving.update(now)
        if not self._moving.seen:
            self._escape, self.is_trapped = None, False
            if self.is_active:
                self._end_when_standing(now)
            return self.is_active
        if now.scan is not self._scan:
            self._scan = now.scan
            self._decide(now, horizon_s)
        elif self.is_active and self._escape is None:
            self._end_when_standing(now)
        return self.is_active or self._escape is not None

    def command(self, now: Observation, wanted: Twist2D) -> Twist2D:
        """Return the twist to command instead of that of the maneuver; mostly the same."""
        if not self.is_active and not self._moving.seen:
            return wanted
        if not self.is_active:
            self._wanted = wanted
            if self._is_safe(now, wanted):
                return wanted
            self.is_active = True
            if self._escape is not None:
                self.times += 1
        self._arc = self._escape or ZERO
        return self._arc

    def _decide(self, now: Observation, horizon_s: float) -> None:
        """Look whether standing is safe, and else for an arc that is better."""
        calm_s = _CALM_S if self._escape is not None else 0.0
        near = self._threat(now, horizon_s + calm_s)
        standing = math.inf
        if near is not None:
            standing = float(self._contact_s(now, near, [ZERO], horizon_s + calm_s)[0][0])
        had, self._escape = self._escape, None
        self.is_trapped = False
        if standing > horizon_s + calm_s:
            if self.is_active:
                self._end_when_standing(now)
            return
        threat = self._threat(now)
        if threat is not None and self.way < self._tuning.give_way_distance:
            self._escape = self._best(now, threat, horizon_s, standing)
        self.is_trapped = self._escape is None
        if self._escape is not None and had is None and self.is_active:
            self.times += 1

    def _end_when_standing(self, now: Observation) -> None:
        """Return the base to its goal once it stands, and the goal's twist is safe."""
        velocity = now.velocity or ZERO
        speed = math.hypot(velocity.linear, velocity.lateral)
        stands = speed < _STANDS_LINEAR and abs(velocity.angular) < _STANDS_ANGULAR
        if stands and (not self._moving.seen or self._is_safe(now, self._wanted)):
            self.is_active = False

    def _is_safe(self, now: Observation, twist: Twist2D) -> bool:
        """Return whether a twist is safe until the next scan, and the stop after it."""
        horizon_s = self._tuning.give_way_time
        threat = self._threat(now, horizon_s)
        if threat is None:
            return True
        for for_s in (_COMMIT_S, horizon_s):
            times, _ = self._contact_s(now, threat, [twist], horizon_s, for_s=for_s)
            if times[0] > horizon_s:
                return for_s == _COMMIT_S or self._are_free(now, threat, [twist], horizon_s)[0]
        return False

    def _threat(self, now: Observation, within_s: float = math.inf) -> MovingPoints | None:
        """Return the moving obstacles that could reach a standing hull within a time."""
        odom = now.odom or Pose2D(0.0, 0.0, 0.0)
        cosine, sine = math.cos(odom.yaw), math.sin(odom.yaw)
        points, rates, turning = [], [], []
        for obstacle in self._moving.seen:
            vx, vy = obstacle.velocity
            seen = into_frame(odom, obstacle.at(now.time_s))
            reach = math.hypot(vx, vy) * within_s + self._body.turning_radius + _CLOSE_M
            if np.hypot(seen[:, 0], seen[:, 1]).min() > reach:
                continue
            seen = seen[:: math.ceil(len(seen) / _MOST_POINTS)]
            points.append(seen)
            rate = (cosine * vx + sine * vy, cosine * vy - sine * vx)
            rates.append(np.broadcast_to(rate, seen.shape))
            turning.append(np.full(len(seen), obstacle.turn_rate))
        if not points:
            return None
        return MovingPoints(np.vstack(points), np.vstack(rates), np.concatenate(turning))

    def _best(
        self, now: Observation, threat: MovingPoints, horizon_s: float, standing: float
    ) -> Twist2D | None:
        """Return the arc that keeps moving obstacles away longest, or None if none helps."""
        arcs = self._arcs()
        whole_s = horizon_s + _BEYOND_S
        times, gaps = self._contact_s(now, threat, arcs, whole_s, for_s=horizon_s)
        free = self._are_free(now, threat, arcs, horizon_s)
        gaps = np.minimum(gaps, _ENOUGH_M)
        gaps -= [_METRE_COSTS * abs(arc.linear) * horizon_s for arc in arcs]
        gaps += [_AGAIN_M if arc == self._arc else 0.0 for arc in arcs]
        ranked = sorted(
            (index for index in range(len(arcs)) if free[index]),
            key=lambda index: (times[index], gaps[index]),
            reverse=True,
        )
        if not ranked or times[ranked[0]] < standing + _GAIN_S:
            return None
        return arcs[ranked[0]]

    def _arcs(self) -> list[Twist2D]:
        linear, angular = self._limits.linear, self._limits.angular
        shares = (-1.0, -0.5, 0.0, 0.5, 1.0)
        sharpest = self._robot.drive.max_curvature
        if math.isfinite(sharpest):  # a car turns only while it drives
            return [
                Twist2D(linear * along, sharpest * abs(linear * along) * round_)
                for along in shares
                for round_ in shares
                if along
            ]
        return [
            Twist2D(linear * along, angular * round_)
            for along in shares
            for round_ in shares
            if along or round_
        ]

    def _contact_s(
        self,
        now: Observation,
        threat: MovingPoints,
        arcs: list[Twist2D],
        whole_s: float,
        *,
        for_s: float = 0.0,
    ) -> tuple[Floats, Floats]:
        """Return when each arc, driven for a time and then stood, meets what moves, s or inf.

        And the least gap until then, m.
        """
        times = np.arange(0.0, whole_s + STEP_S, STEP_S)
        poses = rolled_out(now.velocity or ZERO, arcs, times, for_s, self._limits)
        depth = depth_in(self._wide, poses, threat.at(times))
        # Points that touch already, or nearly, count only if they approach further.
        depth = depth.max(axis=2) - np.maximum(depth[:, :1].max(axis=2), 0.0)
        touching = depth > _DEEPER_M
        first = np.where(touching.any(axis=1), times[touching.argmax(axis=1)], math.inf)
        return first, -depth.max(axis=1)

    def _are_free(
        self, now: Observation, threat: MovingPoints, arcs: list[Twist2D], for_s: float
    ) -> list[bool]:
        """Whether each arc, driven for a time and braked, is free of what stands still."""
        fixed = self._fixed(now, threat)
        if not len(fixed):
            return [True] * len(arcs)
        times = np.arange(0.0, for_s + 0.5, STEP_S)
        poses = rolled_out(now.velocity or ZERO, arcs, times, for_s, self._limits)
        depth = depth_in(self._near, poses, fixed[None])
        allowed = np.maximum(depth[:, :1], 0.0) + _DEEPER_M
        touching: npt.NDArray[np.bool_] = np.any(depth > allowed, axis=(1, 2))
        return [not touches for touches in touching.tolist()]

    def _fixed(self, now: Observation, threat: MovingPoints) -> Points:
        """Return what an arc is not to touch: points of the scan, and directions not looked in."""
        assert now.scan is not None
        lidar = self._robot.lidar
        seen = obstacle_points(now.scan, lidar).T
        reach = self._limits.linear * (self._tuning.give_way_time + 0.5) + self._body.turning_radius
        seen = seen[np.hypot(seen[:, 0], seen[:, 1]) < reach]
        moves = np.hypot(*(seen[:, None] - threat.points).T).min(axis=0) < _OWN_M
        seen = seen[~moves]
        gone = np.hypot(seen[:, 0], seen[:, 1])
        if len(seen) > _MOST_FIXED:
            seen = seen[np.argsort(gone)[:: math.ceil(len(seen) / _MOST_FIXED)]]
        return np.vstack([seen, self._blind(now.scan)])

    def _blind(self, scan: Scan) -> Points:
        """Return points around the hull in directions of which the scan says nothing."""
        ranges = scan.ranges
        silent = ~(ranges >= max(scan.range_min, self._robot.lidar.min_range))
        run = silent.copy()
        for shift in range(1, _BLIND_RAYS):
            run &= np.roll(silent, shift)
        angles = scan.angle_min + scan.angle_increment * np.flatnonzero(run)
        low, high = sorted((scan.angle_min, scan.angle_min + scan.angle_increment * len(ranges)))
        unseen = np.arange(high, low + math.tau - 2 * abs(scan.angle_increment), _BLIND_RAD)
        angles = np.concatenate([angles, unseen])
        radius = self._body.turning_radius + _BLIND_M
        return np.stack([radius * np.cos(angles), radius * np.sin(angles)], axis=1)
