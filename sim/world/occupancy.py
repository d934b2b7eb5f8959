"""The map of a world: the cells of the floor under an obstacle, seen from above.

Moving obstacles are not on it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim.world.shapes import Obstacle
from sim.world.world import World

FREE, OCCUPIED = 0, 100

_TOUCHING = 1e-6
"""Metres by which a shape must reach into a cell; one that ends at its edge does not."""


@dataclass(frozen=True, eq=False)
class OccupancyMap:
    """`cells[row, column]`, row along y, column along x, FREE or OCCUPIED.

    `resolution` is a cell's edge, `origin` the corner of `cells[0, 0]` with the smallest x and y;
    metres.
    """

    resolution: float
    origin: tuple[float, float]
    cells: npt.NDArray[np.int8]


def rasterise(world: World, resolution: float = 0.05) -> OccupancyMap:
    """Return the map of the whole floor. A cell is occupied where any part of it is covered."""
    columns, rows = (math.ceil(edge / resolution - 1e-9) for edge in world.size)
    origin = (-world.size[0] / 2, -world.size[1] / 2)
    xs = origin[0] + (np.arange(columns) + 0.5) * resolution
    ys = origin[1] + (np.arange(rows) + 0.5) * resolution
    cells = np.full((rows, columns), FREE, dtype=np.int8)
    half = resolution / 2 - _TOUCHING
    for obstacle in world.obstacles:
        if obstacle.motion is not None:
            continue
        covered = _in_cylinder if obstacle.kind == "cylinder" else _in_box
        reach = math.hypot(obstacle.size[0], obstacle.size[1]) / 2 + resolution
        near_x = slice(*np.searchsorted(xs, (obstacle.x - reach, obstacle.x + reach)))
        near_y = slice(*np.searchsorted(ys, (obstacle.y - reach, obstacle.y + reach)))
        dx, dy = np.meshgrid(xs[near_x] - obstacle.x, ys[near_y] - obstacle.y)
        cells[near_y, near_x][covered(obstacle, dx, dy, half)] = OCCUPIED
    return OccupancyMap(resolution, origin, cells)


Offsets = npt.NDArray[np.float64]


def _in_cylinder(obstacle: Obstacle, dx: Offsets, dy: Offsets, half: float) -> npt.NDArray[np.bool]:
    """Return whether the cell's nearest point to the axis is within the circle."""
    nearest_x = np.maximum(np.abs(dx) - half, 0.0)
    nearest_y = np.maximum(np.abs(dy) - half, 0.0)
    covered: npt.NDArray[np.bool] = np.hypot(nearest_x, nearest_y) < obstacle.radius
    return covered


def _in_box(obstacle: Obstacle, dx: Offsets, dy: Offsets, half: float) -> npt.NDArray[np.bool]:
    """Whether no axis of the cell or of the box separates them (separating axis theorem)."""
    a, b = obstacle.size[0] / 2, obstacle.size[1] / 2
    cos, sin = math.cos(obstacle.yaw), math.sin(obstacle.yaw)
    c, s = abs(cos), abs(sin)
    along, across = dx * cos + dy * sin, dy * cos - dx * sin
    covered: npt.NDArray[np.bool] = (
        (np.abs(dx) < half + a * c + b * s)
        & (np.abs(dy) < half + a * s + b * c)
        & (np.abs(along) < a + half * (c + s))
        & (np.abs(across) < b + half * (c + s))
    )
    return covered
