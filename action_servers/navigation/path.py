"""A path as a polyline, and how a path over cells becomes one that a robot likes to drive."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from action_servers.navigation.cost import CostModel
from action_servers.navigation.grid import Floats, Survey

SPACING_M = 0.05
"""Distance between the points of a finished path."""

_ROUNDING_M = 0.15
_SAMPLE_M = 0.04


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

    A line must keep the cost model's radius everywhere, unless the stretch did not either: the
    first points of a robot that leaves a tight place.
    """
    corners = _corners(points)
    cheapest = _prices(corners, survey, cost)
    total = np.concatenate(([0.0], np.cumsum(cheapest)))
    kept = [0]
    last = len(corners) - 1
    while kept[-1] < last:
        start = kept[-1]
        lines = _line_prices(corners[start], corners[start + 1 :], survey, cost)
        stretches = total[start + 1 :] - total[start]
        # The first is the stretch itself: it stays, whatever it costs.
        better = np.flatnonzero(lines[1:] <= stretches[1:] * (1 + 1e-9))
        kept.append(start + 1 + (int(better[-1]) + 1 if better.size else 0))
    return corners[kept]


def smooth(points: Floats, survey: Survey, cost: CostModel) -> Path:
    """Space points evenly and round their corners as far as the radius allows; the ends stay."""
    rough = path_through(points)
    count = max(2, int(np.ceil(rough.length / SPACING_M)) + 1)
    at = np.linspace(0.0, rough.length, count)
    even = np.column_stack(
        [np.interp(at, rough.travelled, rough.points[:, axis]) for axis in (0, 1)]
    )
    allowed = np.minimum(survey.clearance_at(even), cost.radius)
    rounding = _ROUNDING_M / SPACING_M
    while rounding > 0.5:
        rounded = _blur(even, rounding)
        # Points move sideways by less than their spacing, so each is held to its own old clearance.
        if np.all(survey.clearance_at(rounded) >= allowed - 1e-9):
            return path_through(rounded)
        rounding /= 2
    return path_through(even)


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
    samples, lengths = _samples(start, ends)
    clearance = survey.clearance_at(samples.reshape(-1, 2)).reshape(samples.shape[:2])
    prices = cost.price(clearance).mean(axis=1) * lengths
    return np.where(clearance.min(axis=1) >= cost.radius, prices, np.inf)


def _samples(start: Floats, ends: Floats) -> tuple[Floats, Floats]:
    lengths = np.hypot(*(ends - start).T)
    count = max(2, int(np.ceil(float(lengths.max()) / _SAMPLE_M)) + 1)
    fractions = np.linspace(0.0, 1.0, count)
    return start + fractions[None, :, None] * (ends - start)[:, None, :], lengths
