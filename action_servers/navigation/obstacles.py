"""The temporary layer: obstacles in the scan that the map lacks."""

from __future__ import annotations

import numpy as np

from action_servers.core.clearance import into_frame, ray_towards
from action_servers.core.grid import Bools, Floats, Survey, centres
from action_servers.core.maneuver import Scan
from action_servers.navigation.tuning import NAVIGATION
from bt_mission.base.geometry import Pose2D

_MARK_RANGE_M = 3.0
_KNOWN_M = 0.12
_KNOWN_PER_M = 0.02
_THROUGH_M = 0.10


class ObstacleLayer:
    """Cells of a survey that are occupied for now, each with the time it was last seen."""

    def __init__(self, survey: Survey, memory_s: float = NAVIGATION.obstacle_memory) -> None:
        """Make a layer over a map, with no mark.

        `memory_s` is how long a mark stays that no ray has confirmed or passed through, s.
        """
        self._survey = survey
        self._memory_s = memory_s
        self._seen: Floats = np.full(survey.shape, -np.inf)
        self.marks: Bools = np.zeros(survey.shape, dtype=np.bool_)

    def over(self, survey: Survey) -> ObstacleLayer:
        """Return a layer over another map, with the marks outside of that map's obstacles."""
        layer = ObstacleLayer(survey, self._memory_s)
        rows, columns = np.nonzero(self.marks)
        layer.mark(centres(self._survey, rows, columns), self._seen[rows, columns], 0.0)
        return layer

    def update(self, scan: Scan, hits: Floats, lidar: Pose2D) -> bool:
        """Mark what a scan hit, clear what it saw through. Return whether any cell changed.

        `hits` are `n x 2` metres and `lidar` the pose of the lidar, both in the map frame at the
        time of the scan.
        """
        before = self.marks
        self._clear(scan, lidar, scan.stamp_s)
        ranges = np.hypot(hits[:, 0] - lidar.x, hits[:, 1] - lidar.y)
        near = ranges <= _MARK_RANGE_M
        self.mark(hits[near], np.full(int(near.sum()), scan.stamp_s), ranges[near])
        return not np.array_equal(before, self.marks)

    def mark(self, points: Floats, seen_s: Floats, ranges: Floats | float) -> None:
        """Mark the cells of `n x 2` points, seen at `seen_s` from `ranges` metres away.

        Points close to a mapped obstacle are that obstacle, seen with noise and pose error, and are
        skipped.
        """
        new = self._survey.clearance_at(points) > _KNOWN_M + _KNOWN_PER_M * ranges
        rows, columns = self._survey.cells(points[new])
        self._seen[rows, columns] = seen_s[new]
        self.marks = self._seen > -np.inf

    def _clear(self, scan: Scan, lidar: Pose2D, time_s: float) -> None:
        rows, columns = np.nonzero(self.marks)
        if not rows.size or scan.angle_increment == 0.0:
            return
        points = into_frame(lidar, centres(self._survey, rows, columns))
        gaps = np.hypot(points[:, 0], points[:, 1])
        bearings = np.arctan2(points[:, 1], points[:, 0]) - scan.angle_min
        ray, whole_turn = ray_towards(scan, bearings)
        count = len(scan.ranges)
        # The two rays beside it as well: a mark is cleared only if all three pass it.
        rays = ray[:, None] + np.array([-1, 0, 1])
        rays = rays % count if whole_turn else np.clip(rays, 0, count - 1)
        beside = scan.ranges[rays]
        seen_through = (
            np.all(beside > (gaps + _THROUGH_M)[:, None], axis=1)
            & (gaps + _THROUGH_M < scan.range_max)
            & (gaps > scan.range_min)
            & (whole_turn | (ray < count))
        )
        gone = seen_through | (self._seen[rows, columns] < time_s - self._memory_s)
        self._seen[rows[gone], columns[gone]] = -np.inf
