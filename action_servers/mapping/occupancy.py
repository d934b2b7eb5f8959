"""An occupancy grid from scans: log-odds of every cell, from rays that end there or pass it.

The evidence of scans adds up as log-odds (A. Elfes, "Using occupancy grids for mobile robot
perception and navigation", 1989). Poses are given: this module maps, it does not localise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from action_servers.core.clearance import of_nearest_rays
from action_servers.core.maneuver import Grid, Scan
from bt_mission.base.geometry import Pose2D, composed
from bt_mission.robots.model import LidarModel

FREE, OCCUPIED, UNKNOWN = 0, 100, -1

OCCUPIED_THRESH = 0.65
"""Probability from which a cell counts as occupied: that of Nav2's map server."""

FREE_THRESH = 0.25
"""Probability up to which a cell counts as free: that of Nav2's map server."""

HIT = 0.90
"""Log-odds of a ray that ends in a cell; a single one makes an unknown cell an obstacle."""

MISS = 0.55
"""Log-odds of a ray that passes a cell; it takes two to make an unknown cell free."""

LEAST, MOST = -3.0, 3.5
"""Bounds of the log-odds of a cell, so that an obstacle that leaves is gone after ten scans."""

_BLOCK_M = 1.0
_LARGEST_M = 100.0
_BEHIND_SURFACE_M = 0.0125
_THROUGH = 0.25
_FINEST_RAD = 1e-5

_HIT, _MISS = np.float32(HIT), np.float32(MISS)

_Odds = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class _Rays:
    """The rays of a scan, one value each.

    `clear` is the free distance, 0 for a ray without a measurement; `ends_x`, `ends_y` are the
    ends, metres in the map frame; `hit` is whether it hits an obstacle.
    """

    clear: npt.NDArray[np.float32]
    ends_x: npt.NDArray[np.float64]
    ends_y: npt.NDArray[np.float64]
    hit: npt.NDArray[np.bool_]


class OccupancyMapper:
    """Adds scans to a map in the frame of the poses.

    The map begins empty and grows by whole metres, up to 100 m along x and y, so that a pose that
    jumps far away cannot fill the memory. `resolution` is the edge of a cell in metres.
    """

    def __init__(self, lidar: LidarModel, *, resolution: float = 0.05) -> None:
        self._reach = lidar.max_range
        self._nearest = lidar.min_range
        self._mount = Pose2D(lidar.x, lidar.y, 0.0)
        self._resolution = resolution
        self._block = max(1, round(_BLOCK_M / resolution))
        self._odds: _Odds = np.zeros((0, 0), dtype=np.float32)
        self._first_row = 0
        self._first_column = 0

    @property
    def empty(self) -> bool:
        """Whether no scan was added yet."""
        return self._odds.size == 0

    def add(self, scan: Scan, pose: Pose2D) -> bool:
        """Add a scan, taken with the base at `pose`. Return False if it is too far away.

        A ray of inf is free up to the range of the lidar. One of NaN, 0, less than the lidar's
        shortest range, or more than its longest, has no effect.
        """
        lidar = composed(pose, self._mount)
        rays = self._read(scan, lidar)
        if not rays.clear.any():
            return True
        rows, columns = self._span(rays, lidar)
        if not self._make_room(rows, columns):
            return False
        window = self._odds[
            rows[0] - self._first_row : rows[1] - self._first_row,
            columns[0] - self._first_column : columns[1] - self._first_column,
        ]
        passed = self._passed(scan, rays, lidar, rows, columns)
        struck = np.zeros(window.shape, dtype=np.bool_)
        struck[
            np.floor(rays.ends_y[rays.hit] / self._resolution).astype(np.intp) - rows[0],
            np.floor(rays.ends_x[rays.hit] / self._resolution).astype(np.intp) - columns[0],
        ] = True
        passed &= ~struck
        window -= _MISS * passed
        window += _HIT * struck
        np.maximum(window, LEAST, out=window)
        np.minimum(window, MOST, out=window)
        return True

    def grid(self, stamp_s: float = 0.0) -> Grid:
        """Return the map as it is: every cell FREE, OCCUPIED or UNKNOWN."""
        cells = np.full(self._odds.shape, UNKNOWN, dtype=np.int8)
        cells[self._odds <= _odds(FREE_THRESH)] = FREE
        cells[self._odds >= _odds(OCCUPIED_THRESH)] = OCCUPIED
        return Grid(
            self._resolution,
            self._first_column * self._resolution,
            self._first_row * self._resolution,
            cells,
            stamp_s,
        )

    def _read(self, scan: Scan, lidar: Pose2D) -> _Rays:
        reach = min(scan.range_max, self._reach)
        ranges = scan.ranges.astype(np.float64)
        with np.errstate(invalid="ignore"):
            hit = (ranges >= max(scan.range_min, self._nearest)) & (ranges <= reach)
        beyond = np.isposinf(ranges)
        lengths = np.where(hit, ranges, np.where(beyond, reach, 0.0))
        # A surface lies in the cell behind it: noise of 0.01 m would else thicken every wall.
        ends = lengths + np.where(hit, _BEHIND_SURFACE_M, 0.0)
        angles = lidar.yaw + scan.angle_min + scan.angle_increment * np.arange(ranges.size)
        return _Rays(
            lengths.astype(np.float32),
            lidar.x + ends * np.cos(angles),
            lidar.y + ends * np.sin(angles),
            hit,
        )

    def _span(self, rays: _Rays, lidar: Pose2D) -> tuple[tuple[int, int], tuple[int, int]]:
        """Return first and last-plus-one row and column of the cells that the scan may change."""
        return (
            self._cells_of(min(lidar.y, rays.ends_y.min()), max(lidar.y, rays.ends_y.max())),
            self._cells_of(min(lidar.x, rays.ends_x.min()), max(lidar.x, rays.ends_x.max())),
        )

    def _cells_of(self, low: float, high: float) -> tuple[int, int]:
        return math.floor(low / self._resolution), math.floor(high / self._resolution) + 1

    def _make_room(self, rows: tuple[int, int], columns: tuple[int, int]) -> bool:
        have_rows, have_columns = self._odds.shape
        low_row, high_row = self._blocks(rows, self._first_row, have_rows)
        low_column, high_column = self._blocks(columns, self._first_column, have_columns)
        height, width = high_row - low_row, high_column - low_column
        if max(height, width) * self._resolution > _LARGEST_M:
            return False
        if (height, width) != (have_rows, have_columns):
            grown = np.zeros((height, width), dtype=np.float32)
            down, right = self._first_row - low_row, self._first_column - low_column
            if not self.empty:
                grown[down : down + have_rows, right : right + have_columns] = self._odds
            self._odds, self._first_row, self._first_column = grown, low_row, low_column
        return True

    def _blocks(self, wanted: tuple[int, int], first: int, count: int) -> tuple[int, int]:
        low = wanted[0] // self._block * self._block
        high = -(-wanted[1] // self._block) * self._block
        return (min(low, first), max(high, first + count)) if count else (low, high)

    def _passed(
        self,
        scan: Scan,
        rays: _Rays,
        lidar: Pose2D,
        rows: tuple[int, int],
        columns: tuple[int, int],
    ) -> npt.NDArray[np.bool_]:
        """Return which cells of a window the scan has seen as free.

        Each cell uses the ray nearest to its middle, so that no cell between two rays is omitted.
        Rays less than 10 microradians apart are not a scan.
        """
        size = self._resolution
        x = (np.arange(*columns, dtype=np.float32) + 0.5) * size - lidar.x
        y = (np.arange(*rows, dtype=np.float32) + 0.5) * size - lidar.y
        x, y = x.astype(np.float32)[None, :], y.astype(np.float32)[:, None]
        gaps = np.sqrt(x * x + y * y)
        if abs(scan.angle_increment) < _FINEST_RAD:
            return np.zeros(gaps.shape, dtype=np.bool_)
        bearings = np.arctan2(y, x) - np.float32(lidar.yaw + scan.angle_min)
        clear = of_nearest_rays(scan, rays.clear, bearings)
        passed: npt.NDArray[np.bool_] = gaps + np.float32(_THROUGH * size) < clear
        return passed


def _odds(probability: float) -> float:
    return math.log(probability / (1.0 - probability))
