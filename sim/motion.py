"""How obstacles move: round a point, or along a way and back; a function of time alone."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Protocol

Point = tuple[float, float]
PlaceAndVelocity = tuple[float, float, float, float]
"""x, y in m, and their rates in m/s."""


class Motion(Protocol):
    """Where something is, and how fast it goes."""

    def at(self, time_s: float) -> PlaceAndVelocity:
        """Return both at a time after the start, s."""

    @property
    def reach(self) -> tuple[Point, ...]:
        """Points between which, or around which, it stays."""


@dataclass(frozen=True)
class Circling:
    """Round `around` (m), once in `period` s; counter-clockwise, clockwise below 0."""

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


class Patrolling:
    """From its place through the points and back to its place, again and again, at `speed` m/s."""

    def __init__(self, points: tuple[Point, ...], speed: float) -> None:
        self._points = (*points, points[0])
        lengths = [math.dist(a, b) for a, b in pairwise(self._points)]
        self._starts = [0.0, *accumulate(lengths)]
        self._speed = speed

    def at(self, time_s: float) -> PlaceAndVelocity:
        """Return place and velocity at a time after the start, s. It turns round at once."""
        gone = math.fmod(time_s * self._speed, self._starts[-1])
        leg = min(bisect_right(self._starts, gone), len(self._points) - 1) - 1
        (x0, y0), (x1, y1) = self._points[leg], self._points[leg + 1]
        length = self._starts[leg + 1] - self._starts[leg]
        ahead_x, ahead_y = (x1 - x0) / length, (y1 - y0) / length
        along = gone - self._starts[leg]
        return (
            x0 + along * ahead_x,
            y0 + along * ahead_y,
            self._speed * ahead_x,
            self._speed * ahead_y,
        )

    @property
    def reach(self) -> tuple[Point, ...]:
        """The corners of the way."""
        return self._points[:-1]
