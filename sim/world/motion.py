"""The motion of obstacles: round a point, along a path, or straight; a function of time alone."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Protocol

Point = tuple[float, float]
PlaceAndVelocity = tuple[float, float, float, float]
"""x, y in m, and their rates in m/s."""


class Course(Protocol):
    """The place and velocity of an obstacle."""

    def at(self, time_s: float) -> PlaceAndVelocity:
        """Return both at a time after the start, s."""


class Motion(Course, Protocol):
    """The course of an obstacle that is in the world from the start and never ends."""

    @property
    def reach(self) -> tuple[Point, ...]:
        """Points between which, or around which, it stays."""


@dataclass(frozen=True)
class Circling:
    """Round `around` (m), once in `period` s; counter-clockwise, clockwise if negative."""

    start: Point
    around: Point
    period: float

    def at(self, time_s: float) -> PlaceAndVelocity:
        """Return place and velocity at a time after the start, s."""
        rate = math.tau / self.period
        angle = rate * math.fmod(time_s, self.period)
        cos, sin = math.cos(angle), math.sin(angle)
        dx, dy = self.start[0] - self.around[0], self.start[1] - self.around[1]
        x, y = cos * dx - sin * dy, sin * dx + cos * dy
        return self.around[0] + x, self.around[1] + y, -rate * y, rate * x

    @property
    def reach(self) -> tuple[Point, ...]:
        """The circle's extremes along x and y."""
        (x, y), radius = self.around, math.dist(self.start, self.around)
        return (x + radius, y), (x - radius, y), (x, y + radius), (x, y - radius)


class PassingCourse:
    """From the first point through the others at `speed` m/s, to stand at the last.

    Each differs from the one before it.
    """

    def __init__(self, points: tuple[Point, ...], speed: float) -> None:
        self._points = points
        self._speed = speed
        lengths = [math.dist(a, b) for a, b in pairwise(points)]
        self._starts = [0.0, *accumulate(lengths)]
        # Start and direction: read at every step of the physics.
        self._legs = []
        legs = zip(pairwise(points), pairwise(self._starts), strict=True)
        for ((x0, y0), (x1, y1)), (start, end) in legs:
            length = end - start
            self._legs.append((start, end, x0, y0, (x1 - x0) / length, (y1 - y0) / length))
        self._leg = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        """The leg of the last answer: the next is mostly on it, too."""

    def at(self, time_s: float) -> PlaceAndVelocity:
        """Return place and velocity at a time after the start, s. It turns at once."""
        return self._after(time_s * self._speed)

    def _after(self, gone: float) -> PlaceAndVelocity:
        """Return place and velocity after some metres."""
        if gone >= self._starts[-1]:
            return *self._points[-1], 0.0, 0.0
        start, end, x, y, ahead_x, ahead_y = self._leg
        if not start <= gone < end:
            self._leg = self._legs[bisect_right(self._starts, gone) - 1]
            start, _, x, y, ahead_x, ahead_y = self._leg
        along, speed = gone - start, self._speed
        return x + along * ahead_x, y + along * ahead_y, speed * ahead_x, speed * ahead_y


class Patrolling(PassingCourse):
    """From its place through the points and back to its place, repeatedly, at `speed` m/s."""

    def __init__(self, points: tuple[Point, ...], speed: float) -> None:
        super().__init__((*points, points[0]), speed)

    def at(self, time_s: float) -> PlaceAndVelocity:
        """Return place and velocity at a time after the start, s. It turns round at once."""
        return self._after(math.fmod(time_s * self._speed, self._starts[-1]))

    @property
    def reach(self) -> tuple[Point, ...]:
        """The corners of the way."""
        return self._points[:-1]


@dataclass(frozen=True)
class Drifting:
    """Straight ahead without end, at `velocity` (m/s along x and y); (0, 0): it stands."""

    start: Point
    velocity: Point = (0.0, 0.0)

    def at(self, time_s: float) -> PlaceAndVelocity:
        """Return place and velocity at a time after the start, s."""
        (x, y), (vx, vy) = self.start, self.velocity
        return x + vx * time_s, y + vy * time_s, vx, vy
