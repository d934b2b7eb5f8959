"""A path as a polyline, and how a path over cells becomes one that a robot likes to drive."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from action_servers.core.grid import Floats, Survey
from action_servers.core.tuning import NAVIGATION, NavigationTuning

SPACING_M = 0.05
"""Distance between the points of a finished path."""

_ROUNDING_M = 0.15
_SAMPLE_M = 0.04

_DISLIKE = 4.0
"""What a metre costs more where the robot only just fits."""


@dataclass(frozen=True, slots=True)
class CostModel:
    """Price of one metre of path: 1 in the open, up to 5 where the robot only just fits.

    `radius` is the least clearance allowed, `comfort` the clearance from which more is of no use,
    both in metres from the middle of the axle; `margin` is what `radius` has beyond the robot's.
    """

    radius: float
    comfort: float
    margin: float

    def price(self, clearance: Floats) -> Floats:
        """Return the price at each clearance; finite below `radius` too, and no less than there."""
        lack = np.clip((self.comfort - clearance) / max(1e-6, self.comfort - self.radius), 0.0, 1.0)
        return 1.0 + _DISLIKE * lack * lack


def cost_model(turning_radius: float, tuning: NavigationTuning = NAVIGATION) -> CostModel:
    """Return the cost model of a robot whose turning circle has a radius in metres."""
    radius = turning_radius + tuning.margin
    return CostModel(radius, radius + tuning.comfort, tuning.margin)


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """Points in the map frame, `n x 2` m, n >= 2; `travelled[i]` is the length up to point i."""

    points: Floats
    travelled: Floats

    @property
    def length(self) -> float:
        """Length in metres."""
        return float(self.travelled[-1])

    def at(self, distance: float) -> tuple[float, float]:
        """Return the point that lies `distance` metres along; the ends beyond the ends."""
        return (
            float(np.interp(distance, self.travelled, self.points[:, 0])),
            float(np.interp(distance, self.travelled, self.points[:, 1])),
        )

    def nearest(self, x: float, y: float, first: float, last: float) -> tuple[float, float]:
        """Return how far along the path is nearest to a point, and how far that is from it, m.

        Only the stretch from `first` to `last` metres is looked at, so that a path that passes
        close to itself is not cut short.
        """
        low = max(0, int(np.searchsorted(self.travelled, first, side="right")) - 1)
        high = min(len(self.points) - 1, int(np.searchsorted(self.travelled, last)))
        low = min(low, high - 1)
        starts = self.points[low:high]
        steps = self.points[low + 1 : high + 1] - starts
        lengths = np.diff(self.travelled[low : high + 1])
        gaps = np.array((x, y)) - starts
        along = np.clip((gaps * steps).sum(axis=1) / np.maximum(lengths, 1e-9), 0.0, lengths)
        feet = starts + steps * (along / np.maximum(lengths, 1e-9))[:, None]
        off = np.hypot(x - feet[:, 0], y - feet[:, 1])
        best = int(np.argmin(off))
        return float(self.travelled[low + best] + along[best]), float(off[best])

    def end_direction(self) -> float:
        """Return the direction in which the path ends, radians."""
        back = self.at(max(0.0, self.length - 2 * SPACING_M))
        end = self.points[-1]
        return float(np.arctan2(end[1] - back[1], end[0] - back[0]))


def path_through(points: Floats) -> Path:
    """Make a path of points; two that coincide are kept."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    return Path(points, np.concatenate(([0.0], np.cumsum(steps))))


def straighten(points: Floats, survey: Survey, cost: CostModel) -> Floats:
    """Replace stretches of a path by straight lines where that costs no more.

    A line must keep the cost model's radius everywhere and stay on known ground, unless it is a
    stretch of the path itself: the first one of a robot that leaves a tight place.
    """
    corners = _corners(points)
    total = np.concatenate(([0.0], np.cumsum(_prices(corners, survey, cost))))
    kept = [0]
    last = len(corners) - 1
    while kept[-1] < last:
        start = kept[-1]
        lines = _line_prices(corners[start], corners[start + 2 :], survey, cost)
        stretches = total[start + 2 :] - total[start]
        better = np.flatnonzero(lines <= stretches * (1 + 1e-9))
        kept.append(start + 2 + int(better[-1]) if better.size else start + 1)
    return corners[kept]


def smooth(points: Floats, survey: Survey, cost: CostModel) -> Path:
    """Space points evenly and round their corners where there is room; the ends stay."""
    even = _spaced(points)
    allowed = np.minimum(survey.clearance_at(even), cost.radius)
    known = survey.known_at(even)
    rounding = _ROUNDING_M / SPACING_M
    while rounding > 0.5:
        rounded = _blur(even, rounding)
        # Points move sideways by less than their spacing, so each is held to its own old place.
        room = np.all(survey.clearance_at(rounded) >= allowed - 1e-9)
        if room and np.all(survey.known_at(rounded) | ~known):
            return path_through(rounded)
        rounding /= 2
    return path_through(even)


def _spaced(points: Floats) -> Floats:
    stretches = [points[:1]]
    for start, end in itertools.pairwise(points):
        count = max(1, math.ceil(math.dist(start, end) / SPACING_M - 1e-9))
        stretches.append(np.linspace(start, end, count + 1)[1:])
    return np.concatenate(stretches)


def _blur(points: Floats, sigma: float) -> Floats:
    reach = min(len(points) - 1, int(np.ceil(4 * sigma)))
    # A point reflection at both ends keeps them where they are.
    before = 2 * points[0] - points[reach:0:-1]
    after = 2 * points[-1] - points[-2 : -reach - 2 : -1]
    longer = np.concatenate((before, points, after))
    blurred: Floats = ndimage.gaussian_filter1d(longer, sigma, axis=0, truncate=3.0)
    inner = blurred[reach : reach + len(points)]
    inner[0], inner[-1] = points[0], points[-1]
    return inner


def _corners(points: Floats) -> Floats:
    if len(points) < 3:
        return points
    steps = np.diff(points, axis=0)
    turns = np.abs(steps[:-1, 0] * steps[1:, 1] - steps[:-1, 1] * steps[1:, 0]) > 1e-12
    return points[np.concatenate(([True], turns, [True]))]


def _prices(points: Floats, survey: Survey, cost: CostModel) -> Floats:
    prices = np.empty(len(points) - 1)
    for index in range(len(points) - 1):
        samples, length = _samples(points[index], points[index + 1 : index + 2])
        clearance = survey.clearance_at(samples.reshape(-1, 2))
        prices[index] = float(cost.price(clearance).mean()) * float(length[0])
    return prices


def _line_prices(start: Floats, ends: Floats, survey: Survey, cost: CostModel) -> Floats:
    if not len(ends):
        return np.empty(0)
    samples, lengths = _samples(start, ends)
    points = samples.reshape(-1, 2)
    clearance = survey.clearance_at(points).reshape(samples.shape[:2])
    prices = cost.price(clearance).mean(axis=1) * lengths
    allowed = (clearance >= cost.radius) & survey.known_at(points).reshape(clearance.shape)
    return np.where(allowed.all(axis=1), prices, np.inf)


def _samples(start: Floats, ends: Floats) -> tuple[Floats, Floats]:
    lengths = np.hypot(*(ends - start).T)
    count = max(2, int(np.ceil(float(lengths.max()) / _SAMPLE_M)) + 1)
    fractions = np.linspace(0.0, 1.0, count)
    return start + fractions[None, :, None] * (ends - start)[:, None, :], lengths
