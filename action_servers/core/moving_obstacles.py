"""The moving obstacles around the robot, from scans at two times.

A point in space that an earlier scan saw as free is occupied now: an obstacle has moved in
(free-space violation). Points that only come into view from behind an obstacle, or by the robot's
own motion, do not count. The others are followed in clusters, in the odometry frame.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from action_servers.core.clearance import Points, of_nearest_rays, out_of_frame, pairs, pose_at
from action_servers.core.maneuver import Observation, Scan
from bt_mission.base.geometry import Pose2D
from bt_mission.robots.model import LidarModel

REACH_M = 2.0
"""Range within which is looked for what moves."""

BACK_S = 0.8
"""Age of the scan that is compared: an object at 0.1 m/s has moved 0.08 m."""

_SHORTEST_BACK_S = 0.3
_PERIOD_S = 0.15
_DEEPER_M = 0.05
"""The depth of a point in free space that counts: 3.5 standard deviations of two rays' noise."""
_LONGEST_TURN_S = 0.3
_FEWEST_POINTS = 3
_JUMP_M = 0.15
_RAYS_APART = 3
_MATCH_M = 0.25
_FORGET_S = 0.5
_FIT_S = 0.8
_SHORTEST_FIT_S = 0.3
_FEWEST_SIGHTINGS = 3
_SLOWEST = 0.05
_FASTEST = 1.2
_SLOWEST_TURNING = 0.2
_LEAST_TURN_RATE = 0.1
_LEAP_M = 0.3

Ranges = npt.NDArray[np.float32]
Indices = npt.NDArray[np.intp]
Complex = npt.NDArray[np.complex128]


@dataclass(frozen=True, slots=True, eq=False)
class MovingObstacle:
    """A moving obstacle: `points` at `stamp_s`, `n x 2` m, and `velocity`, m/s along x and y.

    All in the odometry frame. The points are those in space that was free before: the front. Its
    course turns at `turn_rate`, rad/s, left positive.
    """

    points: Points
    velocity: tuple[float, float]
    turn_rate: float
    stamp_s: float

    def at(self, time_s: float) -> Points:
        """Return its points at a time, if it keeps its course."""
        elapsed_s = time_s - self.stamp_s
        vx, vy = self.velocity
        return pairs(self.points[:, 0] + elapsed_s * vx, self.points[:, 1] + elapsed_s * vy)


@dataclass(slots=True, eq=False)
class _Look:
    """One scan, and the pose of the lidar in the odometry frame when it was taken.

    A lidar measures its rays one after the other: its directions are off by up to `blur`, rad,
    while the base turns.
    """

    scan: Scan
    pose: Pose2D
    blur: float
    _free: dict[int, Ranges] = field(default_factory=dict)

    def free(self, rays: int) -> Ranges:
        """Return the free distance of each direction, m, with `rays` neighbours to both sides.

        A ray without a measurement is not free.
        """
        lengths = self._free.get(rays)
        if lengths is None:
            ranges = self.scan.ranges
            lengths = np.where(ranges >= self.scan.range_min, ranges, np.float32(0.0))
            lengths = np.concatenate((lengths[-rays:], lengths, lengths[:rays]))
            width = 1
            while width < 2 * rays + 1:
                more = min(width, 2 * rays + 1 - width)
                lengths = np.minimum(lengths[:-more], lengths[more:])
                width += more
            self._free[rays] = lengths
        return lengths


@dataclass(slots=True, eq=False)
class _Track:
    """The places of one cluster, with times."""

    seen: deque[tuple[float, float, float]]
    points: Points
    courses: deque[tuple[float, float]] = field(default_factory=deque)
    velocity: tuple[float, float] = (0.0, 0.0)
    turn_rate: float = 0.0

    def add(self, stamp_s: float, points: Points, place: tuple[float, float]) -> None:
        """Add its present place."""
        self.points = points
        self.seen.append((stamp_s, *place))
        while self.seen[0][0] < stamp_s - _FIT_S:
            self.seen.popleft()
        vx, vy = self._fitted()
        self.turn_rate = self._turned(stamp_s, math.atan2(vy, vx), math.hypot(vx, vy))
        # The line through the last places is that of half their time ago.
        angle = self.turn_rate * 0.5 * (stamp_s - self.seen[0][0])
        cosine, sine = math.cos(angle), math.sin(angle)
        self.velocity = cosine * vx - sine * vy, sine * vx + cosine * vy

    def _turned(self, stamp_s: float, course: float, speed: float) -> float:
        """Note the present course, rad; return its rate, 0 if noise hides it."""
        if speed < _SLOWEST_TURNING:
            self.courses.clear()
            return 0.0
        self.courses.append((stamp_s, course))
        while self.courses[0][0] < stamp_s - _FIT_S:
            self.courses.popleft()
        elapsed_s = stamp_s - self.courses[0][0]
        if elapsed_s < _SHORTEST_FIT_S:
            return 0.0
        rate = math.remainder(course - self.courses[0][1], math.tau) / elapsed_s
        return 0.0 if abs(rate) < _LEAST_TURN_RATE else max(-1.0, min(1.0, rate))

    def _fitted(self) -> tuple[float, float]:
        """Return the straight line through its places, m/s; zero while they are too few."""
        times, x, y = np.array(self.seen).T
        if len(times) < _FEWEST_SIGHTINGS or times[-1] - times[0] < _SHORTEST_FIT_S:
            return 0.0, 0.0
        around = times - times.mean()
        spread = float(around @ around)
        return float(around @ x) / spread, float(around @ y) / spread

    def is_at(self, time_s: float, x: float, y: float) -> float:
        """Return how far a place is from where it should be by now, m."""
        last_s, last_x, last_y = self.seen[-1]
        vx, vy = self.velocity
        elapsed_s = time_s - last_s
        return math.hypot(x - last_x - elapsed_s * vx, y - last_y - elapsed_s * vy)


class MovingObstacles:
    """Finds moving obstacles near the robot from the scans of one lidar, and odometry."""

    def __init__(self, lidar: LidarModel) -> None:
        self._lidar = lidar
        self._scan: Scan | None = None
        self._looks: deque[_Look] = deque()
        self._compared_s = -math.inf
        self._tracks: list[_Track] = []
        self.seen: tuple[MovingObstacle, ...] = ()
        """The moving obstacles of the newest scan."""

    def update(self, now: Observation) -> bool:
        """Handle an observation; return whether the moving obstacles have changed."""
        scan = now.scan
        if scan is None or scan is self._scan or now.odom is None:
            return False
        self._scan = scan
        look = self._look(now, scan)
        if self._looks and not _follows(self._looks[-1], look):
            self._looks.clear()
            self._tracks.clear()
            self._compared_s = -math.inf
        self._looks.append(look)
        while len(self._looks) > 1 and self._looks[1].scan.stamp_s <= scan.stamp_s - BACK_S:
            self._looks.popleft()
        period_s = 0.0 if self._tracks else _PERIOD_S
        before = self._looks[0]
        elapsed_s = scan.stamp_s - before.scan.stamp_s
        if scan.stamp_s - self._compared_s < period_s or elapsed_s < _SHORTEST_BACK_S:
            return bool(self.seen)
        self._compared_s = scan.stamp_s
        self._follow(scan.stamp_s, _clusters(look, before, skip=1 if self._tracks else 2))
        had, self.seen = bool(self.seen), tuple(self._moving())
        return had or bool(self.seen)

    def _look(self, now: Observation, scan: Scan) -> _Look:
        base = pose_at(now, scan.stamp_s)
        cosine, sine = math.cos(base.yaw), math.sin(base.yaw)
        x, y = self._lidar.x, self._lidar.y
        pose = Pose2D(
            base.x + x * cosine - y * sine,
            base.y + x * sine + y * cosine,
            base.yaw,
        )
        angular = 0.0 if now.velocity is None else now.velocity.angular
        turn_s = scan.stamp_s - self._looks[-1].scan.stamp_s if self._looks else _LONGEST_TURN_S
        turn_s = min(max(turn_s, 0.0), _LONGEST_TURN_S)
        return _Look(scan, pose, abs(angular) * turn_s)

    def _follow(self, stamp_s: float, clusters: list[Points]) -> None:
        free = list(self._tracks)
        for points in clusters:
            x, y = points.mean(axis=0).tolist()
            track = min(free, key=lambda known: known.is_at(stamp_s, x, y), default=None)
            if track is None or track.is_at(stamp_s, x, y) > _MATCH_M:
                self._tracks.append(_Track(deque([(stamp_s, x, y)]), points))
                continue
            free.remove(track)
            track.add(stamp_s, points, (x, y))
        self._tracks = [known for known in self._tracks if known.seen[-1][0] > stamp_s - _FORGET_S]

    def _moving(self) -> Iterator[MovingObstacle]:
        for track in self._tracks:
            velocity = track.velocity
            if _SLOWEST <= math.hypot(*velocity) <= _FASTEST:
                last_s = track.seen[-1][0]
                yield MovingObstacle(track.points, velocity, track.turn_rate, last_s)


def _follows(before: _Look, look: _Look) -> bool:
    """Return whether two looks can be compared: same lidar, no jump of clock or pose.

    An LDS-02 has a few rays more or less at each turn.
    """
    elapsed_s = look.scan.stamp_s - before.scan.stamp_s
    moved = math.hypot(look.pose.x - before.pose.x, look.pose.y - before.pose.y)
    rays = len(look.scan.ranges), len(before.scan.ranges)
    if min(rays) < _FEWEST_POINTS:
        return False
    return 0.0 < elapsed_s < 2 * BACK_S and moved < _LEAP_M + elapsed_s


def _clusters(look: _Look, before: _Look, *, skip: int) -> list[Points]:
    """Return clusters of points in space that the scan before saw as free; odometry frame.

    If nothing is expected, every `skip`-th ray is checked first.
    """
    scan = look.scan
    near = np.flatnonzero((scan.ranges >= scan.range_min) & (scan.ranges < REACH_M))
    if near.size < _FEWEST_POINTS:
        return []
    if skip > 1:
        _, new = _entered(look, before, near[::skip])
        if new.size < _FEWEST_POINTS // skip:
            return []
    seen, new = _entered(look, before, near)
    if new.size < _FEWEST_POINTS:
        return []
    new_points = out_of_frame(before.pose, pairs(seen.real[new], seen.imag[new]))
    return list(_grouped(new_points, near[new]))


def _entered(look: _Look, before: _Look, rays: Indices) -> tuple[Complex, Indices]:
    """Return points of a scan as the lidar before would see them, and which are new to it."""
    scan, then = look.scan, before.scan
    directions = _directions(len(scan.ranges), scan.angle_min, scan.angle_increment)
    # The lidar's present position and direction, as seen from the earlier one.
    turned = look.pose.yaw - before.pose.yaw
    cosine, sine = math.cos(before.pose.yaw), math.sin(before.pose.yaw)
    across, along = look.pose.x - before.pose.x, look.pose.y - before.pose.y
    seen = directions[rays] * (scan.ranges[rays] * complex(math.cos(turned), math.sin(turned)))
    seen += complex(cosine * across + sine * along, cosine * along - sine * across)
    count = len(then.ranges)
    free = before.free(
        min(1 + math.ceil((look.blur + before.blur) / abs(then.angle_increment)), count // 2)
    )
    free = of_nearest_rays(then, free, np.angle(seen) - then.angle_min)
    return seen, np.flatnonzero(np.abs(seen) < free - _DEEPER_M)


def _grouped(points: Points, rays: Indices) -> Iterator[Points]:
    """Yield points that are neighbours, by their rays and by their places."""
    gaps = np.hypot(*np.diff(points, axis=0).T)
    ends = np.flatnonzero((np.diff(rays) > _RAYS_APART) | (gaps > _JUMP_M)) + 1
    groups = np.split(points, ends)
    # The last ray is beside the first.
    if len(groups) > 1 and math.dist(points[0], points[-1]) < _JUMP_M:
        groups[0] = np.vstack([groups.pop(), groups[0]])
    yield from (group for group in groups if len(group) >= _FEWEST_POINTS)


@lru_cache(maxsize=8)
def _directions(rays: int, angle_min: float, increment: float) -> Complex:
    directions: Complex = np.exp(1j * (angle_min + increment * np.arange(rays)))
    directions.flags.writeable = False
    return directions
