"""One scan of several lidars, as from a lidar that turns in the place of the first.

A direction of the merged scan holds the nearest point that any lidar measured there. Its stamp is
the oldest of all, so that the governor stops the base when one of the lidars is silent.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from action_servers.core.maneuver import Scan
from bt_mission.core.robot.model import LidarModel

_RAYS = 720


class ScanMerger:
    """Merges the scans of the lidars of a robot, whose angles are from ahead of the base."""

    def __init__(self, lidars: Sequence[LidarModel]) -> None:
        self._lidars = lidars
        self._scans: Sequence[Scan | None] = ()
        self._merged: Scan | None = None
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
        first = self._lidars[0]
        # NaN: nobody has measured there. Inf: somebody has, and nothing is there.
        ranges = np.full(_RAYS, np.nan)
        step = math.tau / _RAYS
        hits = []
        for scan, lidar in zip(scans, self._lidars, strict=True):
            angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
            reached = np.where(np.isinf(scan.ranges), scan.range_max, scan.ranges)
            with np.errstate(invalid="ignore"):
                valid = (reached >= scan.range_min) & (reached <= scan.range_max)
            x = lidar.x - first.x + reached[valid] * np.cos(angles[valid])
            y = lidar.y - first.y + reached[valid] * np.sin(angles[valid])
            bins = np.rint(np.arctan2(y, x) / step).astype(np.intp) % _RAYS
            is_hit = np.isfinite(scan.ranges[valid])
            ranges[bins[~is_hit]] = np.inf
            hits.append((bins[is_hit], np.hypot(x, y)[is_hit]))
        for bins, reach in hits:
            ranges[bins] = np.fmin(ranges[bins], np.inf)
            np.minimum.at(ranges, bins, reach)
        return Scan(
            stamp_s=min(scan.stamp_s for scan in scans),
            angle_min=0.0,
            angle_increment=step,
            range_min=min(scan.range_min for scan in scans),
            range_max=self._farthest,
            ranges=ranges.astype(np.float32),
        )
