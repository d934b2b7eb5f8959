"""Shortest paths over the cells of a survey, by the Dijkstra search of SciPy's sparse graphs."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse import csgraph

from action_servers.core.grid import Floats, Survey, centres
from action_servers.core.maneuver import ErrorCode
from action_servers.navigation.path import (
    NAVIGATION,
    CostModel,
    NavigationTuning,
    Path,
    smooth,
    straighten,
)

Point: TypeAlias = tuple[float, float]
_Number = TypeVar("_Number", np.int32, np.float64)

_INSIDE_M = 0.05
"""Nearer than this to an occupied square, the middle of the axle cannot be: the pose is wrong."""

_NEIGHBOURS = ((0, 1), (1, 0), (1, 1), (1, -1))
PRICE_UNIT_M = 1e-5
"""Edges are weighed in whole units of 0.01 mm: sums are exact, so rounding decides no tie."""


@dataclass(frozen=True, slots=True)
class NoPath:
    """Why there is no path: a code of Nav2's planner, and the reason as text."""

    code: ErrorCode
    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class RoadMap:
    """The cells that a robot may stand on, and the price from one to the next.

    `node[row, column]` numbers them, -1 for the others; `centres[node]` is their place, metres;
    `edges` is symmetric.
    """

    survey: Survey
    cost: CostModel
    node: npt.NDArray[np.int32]
    centres: Floats
    edges: sparse.csr_array
    _priced: dict[int, tuple[Floats, npt.NDArray[np.int32]]] = field(
        default_factory=dict, init=False
    )

    def prices_to(self, node: int) -> tuple[Floats, npt.NDArray[np.int32]]:
        """Return the price from each node to one, in units, and each node's next one on that way.

        Those of the last node are kept: a car's search for arcs needs what its plan needed.
        """
        if node not in self._priced:
            self._priced.clear()
            self._priced[node] = csgraph.dijkstra(
                self.edges, indices=node, return_predecessors=True
            )
        return self._priced[node]

    def free_near(self, point: Point, reach: float) -> list[int]:
        """Return the nodes within `reach` metres of a point, nearest first."""
        gaps = np.hypot(*(self.centres - point).T)
        near = np.flatnonzero(gaps <= reach)
        return [int(node) for node in near[np.argsort(gaps[near], kind="stable")]]


def road_map(survey: Survey, cost: CostModel) -> RoadMap:
    """Link every cell that is known and has the clearance of the cost model to its neighbours."""
    clearance = survey.centre_clearance
    free = (clearance >= cost.radius) & survey.known
    node = np.full(free.shape, -1, dtype=np.int32)
    count = int(free.sum())
    node[free] = np.arange(count, dtype=np.int32)
    price = cost.price(clearance) * (0.5 * survey.resolution / PRICE_UNIT_M)
    sources, targets, weights = [], [], []
    for down, right in _NEIGHBOURS:
        here, there = _shifted(node, down, right)
        price_here, price_there = _shifted(price, down, right)
        linked = (here >= 0) & (there >= 0)
        sources.append(here[linked])
        targets.append(there[linked])
        step = math.hypot(down, right)
        weights.append(np.rint((price_here[linked] + price_there[linked]) * step))
    source, target = np.concatenate(sources), np.concatenate(targets)
    weight = np.concatenate(weights)
    edges = sparse.csr_array(
        (
            np.concatenate((weight, weight)),
            (np.concatenate((source, target)), np.concatenate((target, source))),
        ),
        shape=(count, count),
    )
    return RoadMap(survey, cost, node, centres(survey, *np.nonzero(free)), edges)


def plan(
    roads: RoadMap, start: Point, goal: Point, tuning: NavigationTuning = NAVIGATION
) -> Path | NoPath:
    """Find the cheapest path between two points in metres, straightened and smoothed.

    A robot too close to an obstacle first moves to the nearest free cell. The path ends at the goal
    if the robot can turn there, else at the nearest free cell within `goal_distance` of it.
    """
    survey = roads.survey
    if not survey.contains(*start):
        return NoPath(ErrorCode.START_OUTSIDE_MAP, f"the robot, at {at(start)}, is outside the map")
    nearby = goal_nodes(roads, goal, tuning)
    if isinstance(nearby, NoPath):
        return nearby
    # Searched from the goal, because a robot in a tight place has several cells to begin at.
    price, towards = roads.prices_to(nearby[0])
    starts = departures(roads, start, tuning.start_reach)
    if not starts:
        return NoPath(ErrorCode.START_OCCUPIED, f"the robot is stuck at {_room(roads, start)}")
    node = next((node for node in starts if np.isfinite(price[node])), None)
    if node is None:
        return NoPath(
            ErrorCode.NO_VALID_PATH,
            f"no path from {at(start)} to {at(goal)} keeps {roads.cost.radius:.2f} m "
            "from every obstacle",
        )
    nodes = [node]
    while nodes[-1] != nearby[0]:
        nodes.append(int(towards[nodes[-1]]))
    turns_at_goal = survey.clearance_of(*goal) >= roads.cost.radius - roads.cost.margin
    ends = [goal] if turns_at_goal else [roads.centres[nearby[0]]]
    points = np.concatenate(([start], roads.centres[nodes], ends))
    return smooth(straighten(points, survey, roads.cost), survey, roads.cost)


def goal_nodes(
    roads: RoadMap, goal: Point, tuning: NavigationTuning = NAVIGATION
) -> list[int] | NoPath:
    """Return the nodes at which a path to a point (m) may end, nearest first, or why none."""
    if not roads.survey.contains(*goal):
        return NoPath(ErrorCode.GOAL_OUTSIDE_MAP, f"the goal {at(goal)} is outside the map")
    nearby = roads.free_near(goal, tuning.goal_distance)
    if nearby:
        return nearby
    return NoPath(
        ErrorCode.GOAL_OCCUPIED, f"the robot does not fit at the goal {_room(roads, goal)}"
    )


def departures(roads: RoadMap, start: Point, reach: float = NAVIGATION.start_reach) -> list[int]:
    """Return the nodes at which a path from a point can begin, nearest first.

    A robot closer to an obstacle than allowed has only those within `reach` metres that lead away
    from it.
    """
    clearance = roads.survey.clearance_of(*start)
    row, column = roads.survey.cell(*start)
    if roads.node[row, column] >= 0:
        return [int(roads.node[row, column])]
    if clearance < _INSIDE_M:
        return []
    return [
        node
        for node in roads.free_near(start, reach)
        if _leads_out(roads.survey, start, roads.centres[node], clearance, reach)
    ]


def _leads_out(survey: Survey, start: Point, end: Floats, clearance: float, reach: float) -> bool:
    line = np.linspace(start, end, max(2, int(reach / _INSIDE_M)))
    return bool(np.all(survey.clearance_at(line) >= clearance - _INSIDE_M / 2))


def at(point: Point) -> str:
    """Write a point for a message."""
    return f"({point[0]:.2f}, {point[1]:.2f})"


def _room(roads: RoadMap, point: Point) -> str:
    row, column = roads.survey.cell(*point)
    if not roads.survey.known[row, column]:
        return f"{at(point)}: the map does not know that place"
    room = roads.survey.clearance_of(*point)
    return f"{at(point)}: {room:.2f} m to the nearest obstacle, it needs {roads.cost.radius:.2f} m"


def _shifted(
    field: npt.NDArray[_Number], down: int, right: int
) -> tuple[npt.NDArray[_Number], npt.NDArray[_Number]]:
    """Return two views of a field, whose equal places are a cell and its neighbour."""
    rows, columns = field.shape
    here = field[: rows - down, max(0, -right) : columns - max(0, right)]
    there = field[down:, max(0, right) : columns + min(0, right)]
    return here, there
