"""A fake robot among cylinders that move, with a pilot that gives way to them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from itertools import pairwise

import numpy as np

from action_servers.core.governor import Governor
from action_servers.core.maneuver import ZERO, Maneuver, Observation, Scan
from action_servers.core.pilot import ManeuverOutcome, ManeuverRun, Pilot
from action_servers.core.tuning import TUNING
from bt_mission.robots.model import RobotModel
from sim.world.motion import Course
from tests.support.fake_robot import FakeRobot, Wall, cast_rays

SIDES = 16
NOISE_M = 0.01
SKEW_RAYS = 20


@dataclasses.dataclass(frozen=True)
class Mover:
    """An upright cylinder on its course, m; time counts from the robot's first instant."""

    course: Course
    radius: float = 0.15

    def walls(self, time_s: float) -> list[Wall]:
        """Return its outline at a time."""
        x, y, *_ = self.course.at(time_s)
        turns = [math.tau * side / SIDES for side in range(SIDES + 1)]
        points = [(x + self.radius * math.cos(a), y + self.radius * math.sin(a)) for a in turns]
        return [(*a, *b) for a, b in pairwise(points)]


class MovingWorld:
    """A robot in the care of a pilot; its lidar is noisy, with a seed. `gap` is the truth, m.

    `turn_s` is how long the lidar takes for a turn, its rays one after the other; the stamp is
    that of the last. 0: all at once.
    """

    def __init__(
        self,
        robot: RobotModel,
        movers: Iterable[Mover] = (),
        walls: Iterable[Wall] = (),
        *,
        gives_way: bool = True,
        seed: int = 1,
        turn_s: float = 0.0,
    ) -> None:
        self.base = FakeRobot(robot)
        self.least_gap = math.inf
        self.notes: list[str] = []
        self.outcomes: list[ManeuverOutcome] = []
        self.held = 0
        self._movers = list(movers)
        self._fixed = list(walls)
        self._turn_s = turn_s
        self.base.scan_period_s = turn_s or self.base.scan_period_s
        self._start_s = self.base.time_s
        self._rng = np.random.default_rng(seed)
        self._scan: Scan | None = None
        tuning = dataclasses.replace(TUNING, give_way_time=2.5 if gives_way else 0.0)
        governor = Governor(robot, tuning)
        self.give_way = governor.give_way
        self.pilot = Pilot(self.observe, self.base.move, governor)

    @property
    def time_s(self) -> float:
        """Time since the start, s."""
        return self.base.time_s - self._start_s

    def observe(self) -> Observation:
        """What the robot's topics would tell now."""
        walls = [
            *self._fixed,
            *(wall for mover in self._movers for wall in mover.walls(self.time_s)),
        ]
        self.base.walls = np.array(walls, dtype=float).reshape(-1, 4)
        now = self.base.observe()
        assert now.scan is not None
        if now.scan is not self._scan:
            self._scan = now.scan
            if self._turn_s:
                self._skew(now.scan)
            now.scan.ranges[:] += self._rng.normal(0.0, NOISE_M, len(now.scan.ranges))
        return now

    def _skew(self, scan: Scan) -> None:
        base, lidar = self.base, self.base.robot.lidar
        count = len(scan.ranges)
        late_s = self._turn_s * (1.0 - np.arange(count) / count)
        angles = base.yaw - base.angular * late_s + scan.angle_increment * np.arange(count)
        x = base.x + lidar.x * math.cos(base.yaw) - base.linear * math.cos(base.yaw) * late_s
        y = base.y + lidar.x * math.sin(base.yaw) - base.linear * math.sin(base.yaw) * late_s
        for index in range(0, count, SKEW_RAYS):
            part = slice(index, index + SKEW_RAYS)
            scan.ranges[part] = cast_rays(x[index], y[index], angles[part], base.walls)

    def start(self, maneuver: Maneuver) -> ManeuverRun:
        """Put a maneuver into the pilot's care."""
        run = ManeuverRun(maneuver, lambda _: None, self.outcomes.append, self.notes.append)
        self.pilot.start(run)
        return run

    def run(self, seconds: float) -> None:
        """Let time pass; without a goal the base stands."""
        end_s = self.time_s + seconds
        while self.time_s < end_s - 1e-6:
            before_s = self.time_s
            if not self.pilot.idle:
                self.pilot.step()
                self.held += self.give_way.is_active
            if self.time_s == before_s:
                self.base.move(self.base.twists[-1] if self.base.twists else ZERO)
            self.least_gap = min(self.least_gap, self.gap())

    def gap(self) -> float:
        """How far the nearest mover is from the hull's rectangle, m; 0 or less: contact."""
        hull = self.base.robot.hull
        cosine, sine = math.cos(self.base.yaw), math.sin(self.base.yaw)
        gaps = [math.inf]
        for mover in self._movers:
            x, y, *_ = mover.course.at(self.time_s)
            across, along = x - self.base.x, y - self.base.y
            ahead, left = cosine * across + sine * along, cosine * along - sine * across
            beyond = max(ahead - hull.front, hull.rear - ahead, 0.0)
            gaps.append(math.hypot(beyond, max(abs(left) - hull.half_width, 0.0)) - mover.radius)
        return min(gaps)
