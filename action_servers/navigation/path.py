"""A path as a polyline, its smoothing, and the parameters of navigation."""

from __future__ import annotations

import itertools
import math
from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from scipy import ndimage

from action_servers.core.grid import Floats, Survey
from bt_mission.base.parameters import number


@dataclass(frozen=True, slots=True, kw_only=True)
class NavigationTuning:
    """Of all that drives on a map: the servers' parameters `navigation.*`. Angles in rad."""

    PREFIX: ClassVar = "navigation."

    blind_after: float = number(
        0.5,
        (0.1, 10.0),
        "Age of a scan or pose at which the robot stops, s: five scans of a Waffle, ten poses.",
    )
    give_up_after: float = number(
        3.0, (0.2, 60.0), "Age of a scan or pose at which the goal is given up, s."
    )
    wait: float = number(
        1.0,
        (0.1, 60.0),
        "How long the robot waits for what is in its way to leave, before it plans around it, s.",
    )
    recover_after: float = number(
        5.0,
        (0.5, 600.0),
        "How long it gets nowhere before it forgets what it saw, looks again and plans afresh, s.",
    )
    patience: float = number(
        10.0,
        (1.0, 3600.0),
        "How long it gets nowhere before it gives up, s (that of Nav2's progress checker).",
    )
    obstacle_memory: float = number(
        60.0,
        (1.0, 3600.0),
        "How long an obstacle that the map does not have is remembered out of sight, s.",
    )
    margin: float = number(
        0.01,
        (0.0, 0.5),
        "Kept on top of the robot's turning circle, for what a follower strays from its path, m.",
    )
    comfort: float = number(
        0.25, (0.0, 2.0), "Clearance beyond the necessary from which more is of no use, m."
    )
    goal_distance: float = number(
        0.10,
        (0.0, 1.0),
        "How far beside the goal a path may end when the robot does not fit at the goal itself, m.",
    )
    start_reach: float = number(
        0.50,
        (0.1, 2.0),
        "How far from the robot a path may begin when it stands closer than it should, m.",
    )
    arrival_distance: float = number(
        0.01, (0.001, 0.2), "The drive ends this far before the end of the path, m."
    )
    arrival_angle: float = number(
        0.02, (0.005, 3.2), "The last turn ends this close to the goal's yaw, rad."
    )
    passing_distance: float = number(
        0.4,
        (0.05, 5.0),
        "Distance to a pose of navigate_through_poses, except the last, at which the robot "
        "continues to the next, m.",
    )
    stop_on_failure: bool = number(
        True,
        (0, 1),
        "Whether follow_waypoints ends at the first pose that is not reached (Nav2's default), "
        "or continues, and reports the missed poses at the end.",
    )


NAVIGATION = NavigationTuning()
"""The defaults."""


SPACING_M = 0.05
"""Distance between the points of a finished path."""

_ROUNDING_M = 0.15
_SAMPLE_M = 0.04

_DISLIKE = 4.0
"""The extra price of a metre where the robot only just fits."""


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


@dataclass(frozen=True, eq=False)
class Path:
    """Points in the map frame, `n x 2` m, n >= 2; `travelled[i]` is the length up to point i."""

    points: Floats
    travelled: Floats

    @property
    def length(self) -> float:
        """Length in metres."""
        return float(self.travelled[-1])

    def at(self, distance: float) -> tuple[float, float]:
        """Return the point `distance` metres along the path; beyond the ends, the ends."""
        travelled, points = self._lists
        if distance >= travelled[-1]:
            return points[-1][0], points[-1][1]
        index = max(0, bisect_right(travelled, distance) - 1)
        (x, y), (end_x, end_y) = points[index], points[index + 1]
        length = travelled[index + 1] - travelled[index]
        gone = max(0.0, distance - travelled[index])
        return (end_x - x) / length * gone + x, (end_y - y) / length * gone + y

    def nearest(self, x: float, y: float, first: float, last: float) -> tuple[float, float]:
        """Return the length along the path to the point nearest to (x, y), and its distance, m.

        Only the stretch from `first` to `last` metres is searched, so that a path that passes close
        to itself is not cut short.
        """
        travelled, points = self._lists
        low = max(0, bisect_right(travelled, first) - 1)
        high = min(len(points) - 1, bisect_left(travelled, last))
        low = min(low, high - 1)
        nearest, least = 0.0, math.inf
        start_x, start_y = points[low]
        for index in range(low, high):
            end_x, end_y = points[index + 1]
            step_x, step_y = end_x - start_x, end_y - start_y
            length = travelled[index + 1] - travelled[index]
            gap = (x - start_x) * step_x + (y - start_y) * step_y
            along = min(max(gap / max(length, 1e-9), 0.0), length)
            share = along / max(length, 1e-9)
            off = abs(complex(x - (start_x + step_x * share), y - (start_y + step_y * share)))
            if off < least:
                nearest, least = travelled[index] + along, off
            start_x, start_y = end_x, end_y
        return nearest, least

    @cached_property
    def _lists(self) -> tuple[list[float], list[list[float]]]:
        """Both as lists: single numbers of an array take ten times as long to read."""
        return self.travelled.tolist(), self.points.tolist()

    def end_direction(self) -> float:
        """Return the direction in which the path ends, radians."""
        back = self.at(max(0.0, self.length - 2 * SPACING_M))
        end = self.points[-1]
        return float(np.arctan2(end[1] - back[1], end[0] - back[0]))


def path_through(points: Floats) -> Path:
    """Make a path of points; two equal ones are kept."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    return Path(points, np.concatenate(([0.0], np.cumsum(steps))))


def straighten(points: Floats, survey: Survey, cost: CostModel) -> Floats:
    """Replace stretches of a path by straight lines if that does not cost more.

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
    """Space points evenly and round their corners where there is space; the ends stay."""
    even = _spaced(points)
    allowed = np.minimum(survey.clearance_at(even), cost.radius)
    known = survey.known_at(even)
    rounding = _ROUNDING_M / SPACING_M
    while rounding > 0.5:
        rounded = _blur(even, rounding)
        # Points move sideways by less than their spacing, so each is compared with its old place.
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
