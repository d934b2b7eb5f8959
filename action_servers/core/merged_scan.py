"""One scan of several lidars, as from a lidar that turns in the place of the first.

A direction of the merged scan holds the nearest point that any lidar measured there. Its stamp is
the oldest of all, so that the governor stops the base when one of the lidars is silent.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from action_servers.core.maneuver import Scan
from bt_mission.robots.model import LidarModel

_RAYS = 720

_Geometry: TypeAlias = tuple[int, float, float, float, float]
"""The number of rays, the first angle and the step, rad, and the limits of ranges, m."""


@dataclass(frozen=True, slots=True)
class _ScanRays:
    """The rays of all lidars: limits of ranges, directions and origins, m from the first lidar."""

    least: npt.NDArray[np.float32]
    most: npt.NDArray[np.float32]
    towards: npt.NDArray[np.complex128]
    origins: npt.NDArray[np.complex128]


class ScanMerger:
    """Merges the scans of the lidars of a robot, whose angles are from ahead of the base."""

    def __init__(self, lidars: Sequence[LidarModel]) -> None:
        self._lidars = lidars
        self._scans: Sequence[Scan | None] = ()
        self._merged: Scan | None = None
        self._geometries: tuple[_Geometry, ...] = ()
        first = lidars[0]
        self._farthest = max(
            lidar.max_range + math.hypot(lidar.x - first.x, lidar.y - first.y) for lidar in lidars
        )

    def merged(self, scans: Sequence[Scan | None]) -> Scan | None:
        """Return the scan of all; None until each lidar has measured.

        The same object is returned until one of the scans is newer.
        """
        known = self._scans
        if len(known) != len(scans) or any(a is not b for a, b in zip(scans, known, strict=True)):
            self._scans = tuple(scans)
            self._merged = self._merge([scan for scan in scans if scan is not None])
        return self._merged

    def _merge(self, scans: list[Scan]) -> Scan | None:
        if len(scans) < len(self._lidars):
            return None
        ranges = np.concatenate([scan.ranges for scan in scans])
        rays = self._rays_of(tuple(map(_geometry, scans)))
        with np.errstate(invalid="ignore"):
            is_hit = (ranges >= rays.least) & (ranges <= rays.most)
        is_valid = is_hit | np.isinf(ranges)
        ends = rays.towards * np.fmin(ranges, rays.most) + rays.origins
        step = math.tau / _RAYS
        # From -360 to 360; the negative ones count from the end of the merged scan.
        bins = np.rint(np.arctan2(ends.imag, ends.real) / step).astype(np.intp)
        reach = np.where(is_hit, np.abs(ends), np.inf)
        if not is_valid.all():
            bins, reach = bins[is_valid], reach[is_valid]
        # NaN: nobody has measured there. Inf: somebody has, and nothing is there.
        merged = np.full(_RAYS, np.nan)
        merged[bins] = np.inf
        np.minimum.at(merged, bins, reach)
        return Scan(
            stamp_s=min(scan.stamp_s for scan in scans),
            angle_min=0.0,
            angle_increment=step,
            range_min=min(scan.range_min for scan in scans),
            range_max=self._farthest,
            ranges=merged.astype(np.float32),
        )

    def _rays_of(self, geometries: tuple[_Geometry, ...]) -> _ScanRays:
        """Return the rays of scans; the same object while no geometry changes."""
        if geometries != self._geometries:
            first = self._lidars[0]
            least, most, towards, origins = [], [], [], []
            for (count, angle, step, nearest, farthest), lidar in zip(
                geometries, self._lidars, strict=True
            ):
                least.append(np.full(count, nearest, dtype=np.float32))
                most.append(np.full(count, farthest, dtype=np.float32))
                towards.append(np.exp(1j * (angle + step * np.arange(count))))
                origins.append(np.full(count, complex(lidar.x - first.x, lidar.y - first.y)))
            self._rays = _ScanRays(*map(np.concatenate, (least, most, towards, origins)))
            self._geometries = geometries
        return self._rays


def _geometry(scan: Scan) -> _Geometry:
    count = len(scan.ranges)
    return count, scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max
