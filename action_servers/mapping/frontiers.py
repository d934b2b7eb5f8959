"""The edges of the known area: free cells beside unknown ones, and which to drive to next.

After B. Yamauchi, "A frontier-based approach for autonomous exploration", CIRA 1997.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

from action_servers.core.grid import OCCUPIED_FROM, Bools, Floats, Survey, centres
from action_servers.core.maneuver import Grid
from action_servers.mapping.occupancy import UNKNOWN
from action_servers.navigation.planner import PRICE_UNIT_M, Point, RoadMap, departures
from bt_mission.base.geometry import Pose2D, wrap

REACH_M = 1.0
"""The distance to a frontier at which the robot may end if it cannot stand on it; it must see it.
"""

SIZE_GAIN = 0.5
"""Metres of way that a metre of frontier is worth."""

LARGEST_M = 3.0
"""A longer frontier is not preferred: from its middle, the lidar sees no farther."""

TURN_COST_M = 0.3
"""Metres of way that a radian of turning towards it costs."""

_ALL_AROUND = np.ones((3, 3), dtype=np.bool_)
_SAMPLES = 24
_STARTS = 8


@dataclass(frozen=True, slots=True, eq=False)
class Frontier:
    """A stretch of free cells beside unknown ones; metres in the map frame.

    `points` are the centres of its cells, `n x 2`, the one in its middle first; `size` is its
    length.
    """

    points: Floats
    size: float

    @property
    def middle(self) -> Point:
        """The point of the frontier that is nearest to its centre."""
        return float(self.points[0, 0]), float(self.points[0, 1])


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """A frontier, the pose to see it from, and its price: metres of way, less its worth."""

    frontier: Frontier
    pose: Pose2D
    price: float


def edge_cells(grid: Grid) -> Bools:
    """Return which cells are free and have an unknown one beside them; outside the grid is unknown.

    Unknown cells that touch an obstacle do not count: rays that graze a wall leave such seams, and
    no robot fits into them.
    """
    seam = ndimage.binary_dilation(grid.cells >= OCCUPIED_FROM, _ALL_AROUND)
    unknown = np.pad((grid.cells == UNKNOWN) & ~seam, 1, constant_values=True)
    beside = unknown[:-2, 1:-1] | unknown[2:, 1:-1] | unknown[1:-1, :-2] | unknown[1:-1, 2:]
    edges: Bools = beside & (grid.cells >= 0) & (grid.cells < OCCUPIED_FROM)
    return edges


def frontiers(
    grid: Grid, shortest: float, given_up: Sequence[Point] = (), around: float = 0.0
) -> list[Frontier]:
    """Return the frontiers of a map that are at least `shortest` metres long.

    Cells less than `around` metres from a point that was given up are no part of any.
    """
    edges = edge_cells(grid)
    rows, columns = np.nonzero(edges)
    places = centres(grid, rows, columns)
    for x, y in given_up:
        left_out = np.hypot(places[:, 0] - x, places[:, 1] - y) < around
        edges[rows[left_out], columns[left_out]] = False
    labels, count = ndimage.label(edges, structure=_ALL_AROUND)
    label = labels[rows, columns]
    groups = []
    for number in range(1, count + 1):
        points = places[label == number]
        size = len(points) * grid.resolution
        if size >= shortest - 1e-9:
            groups.append(Frontier(_middle_first(points), size))
    return groups


def choose(
    candidates: Sequence[Frontier], roads: RoadMap, pose: Pose2D
) -> tuple[Target | None, list[Frontier]]:
    """Return the best frontier to drive to, and those that no way leads to.

    The best has the lowest price: a short way and little turning, less what its length is worth.
    """
    here = (pose.x, pose.y)
    starts = departures(roads, here) if roads.survey.contains(*here) else []
    if not starts:
        return None, list(candidates)
    ways = csgraph.dijkstra(roads.edges, indices=starts[:_STARTS], min_only=True)
    prices = ways * PRICE_UNIT_M
    reachable = np.flatnonzero(np.isfinite(prices))
    tree = cKDTree(roads.centres[reachable])
    best: Target | None = None
    shut_off = []
    for frontier in candidates:
        place = _viewpoint(frontier, roads.survey, roads.centres[reachable], tree)
        if place is None:
            shut_off.append(frontier)
            continue
        index, seen = place
        node = reachable[index]
        x, y = (float(part) for part in roads.centres[node])
        ahead = wrap(math.atan2(y - pose.y, x - pose.x) - pose.yaw)
        price = float(prices[node]) + TURN_COST_M * abs(ahead)
        price -= SIZE_GAIN * min(frontier.size, LARGEST_M)
        if best is None or price < best.price:
            yaw = math.atan2(float(seen[1]) - pose.y, float(seen[0]) - pose.x)
            best = Target(frontier, Pose2D(x, y, yaw), price)
    return best, shut_off


def _middle_first(points: Floats) -> Floats:
    gaps = np.hypot(*(points - points.mean(axis=0)).T)
    return points[np.argsort(gaps, kind="stable")]


def _viewpoint(
    frontier: Frontier, survey: Survey, places: Floats, tree: cKDTree
) -> tuple[int, Floats] | None:
    """Return the index of a place from which the frontier is near and seen, and the cells seen."""
    points = frontier.points[:: max(1, len(frontier.points) // _SAMPLES)]
    gaps, nearest = tree.query(points)
    # From the middle of the frontier outwards, places on it before places beside it.
    for rank in np.argsort(np.maximum(gaps, survey.resolution), kind="stable"):
        if gaps[rank] > REACH_M:
            return None
        index = int(nearest[rank])
        if _sees(survey, places[index], points[rank]):
            return index, points[rank]
    return None


def _sees(survey: Survey, place: Floats, point: Floats) -> bool:
    count = max(2, math.ceil(2.0 * math.dist(place, point) / survey.resolution))
    rows, columns = survey.cells(np.linspace(place, point, count))
    return not bool(survey.occupied[rows, columns].any())
