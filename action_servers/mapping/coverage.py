"""How much of the world is mapped, and how much is visited."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from action_servers.core.maneuver import Grid
from bt_mission.base.geometry import Pose2D

Indices = npt.NDArray[np.intp]

ZONE_M = 1.0
"""Edge of a zone: a square of the map frame that begins at whole metres."""

INSIDE_M = 0.05
"""The distance within a zone that the robot must reach: a robot on a corner has not visited four.
"""

_ZONE_SHARE = 0.5


@dataclass(frozen=True, slots=True)
class Measure:
    """The known part of the world.

    `area` is that of all cells that are free or occupied, m²; `fraction` its share of all cells
    within the bounds of the map. `zones_visited` counts the zones in which the middle of the
    robot's axle has been, `zones` those and all others of which half is known to be free.
    """

    area: float
    fraction: float
    zones_visited: int
    zones: int


class VisitedArea:
    """Remembers where the robot has been."""

    def __init__(self) -> None:
        self._visited: set[tuple[int, int]] = set()

    def visit(self, pose: Pose2D) -> None:
        """Note that the robot is at a pose of the map frame."""
        zone = math.floor(pose.x / ZONE_M), math.floor(pose.y / ZONE_M)
        inside = [at - index * ZONE_M for at, index in zip((pose.x, pose.y), zone, strict=True)]
        if min(inside) >= INSIDE_M and max(inside) <= ZONE_M - INSIDE_M:
            self._visited.add(zone)

    def measure(self, grid: Grid) -> Measure:
        """Measure a map that was made on the way."""
        cells = grid.cells
        known = int(np.count_nonzero(cells >= 0))
        visited = len(self._visited)
        return Measure(
            known * grid.resolution**2,
            known / cells.size if cells.size else 0.0,
            visited,
            len(self._visited | _open_zones(grid)),
        )


def _open_zones(grid: Grid) -> set[tuple[int, int]]:
    free = grid.cells == 0
    if not free.any():
        return set()
    rows, columns = grid.cells.shape
    along, first_rows = _zones(grid.origin_y, rows, grid.resolution)
    across, first_columns = _zones(grid.origin_x, columns, grid.resolution)
    by_row = np.add.reduceat(free, first_rows, axis=0, dtype=np.int64)
    counts = np.add.reduceat(by_row, first_columns, axis=1)
    enough = counts * grid.resolution**2 >= _ZONE_SHARE * ZONE_M**2 - 1e-9
    return {(int(across[x]), int(along[y])) for y, x in zip(*np.nonzero(enough), strict=True)}


def _zones(origin: float, cells: int, resolution: float) -> tuple[Indices, Indices]:
    """Return the zones that a row of cells crosses, and the first cell of each."""
    middles = origin + (np.arange(cells) + 0.5) * resolution
    zones, first = np.unique(np.floor(middles / ZONE_M).astype(int), return_index=True)
    return zones, first
