"""The state of the world for navigation: the map, and obstacles in scans that the map lacks."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from action_servers.core.action import PublishedTopic
from action_servers.core.clearance import into_frame, obstacle_points, out_of_frame, ray_towards
from action_servers.core.grid import Bools, Floats, Survey, centres, survey
from action_servers.core.maneuver import Fields, Grid, Observation, Scan
from action_servers.navigation.path import NAVIGATION, CostModel, NavigationTuning, cost_model
from action_servers.navigation.planner import RoadMap, road_map
from action_servers.navigation.pose_history import PoseHistory
from bt_mission.base.geometry import Pose2D, composed
from bt_mission.robots.model import RobotModel

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


_NEAR_M = 1.2


PLAN = PublishedTopic("plan", "nav_msgs/msg/Path", is_latched=True)
"""The path that is driven, as Nav2 publishes it: for RViz and Foxglove."""


def ignore(_path: Fields) -> None:
    """Do nothing with a path."""


class Surroundings:
    """The map with what the lidar adds, kept up to date by `observe`.

    A scan is placed by the pose that the robot had at the scan's stamp. `publish` sends the fields
    of `PLAN`.
    """

    def __init__(
        self,
        robot: RobotModel,
        tuning: NavigationTuning = NAVIGATION,
        publish: Callable[[Fields], object] = ignore,
    ) -> None:
        self.tuning = tuning
        self._publish = publish
        self._lidar = robot.lidar
        self._mount = Pose2D(robot.lidar.x, robot.lidar.y, 0.0)
        self.cost: CostModel = cost_model(robot.passing_radius, tuning)
        self._poses = PoseHistory()
        self._grid: Grid | None = None
        self._scan: Scan | None = None
        self._mapped: Survey | None = None
        self._layer: ObstacleLayer | None = None
        self._survey: Survey | None = None
        self._roads: RoadMap | None = None
        self._near_in_map: Floats = np.empty((0, 2))

    def observe(self, now: Observation) -> None:
        """Take in a new map, pose and scan."""
        if now.grid is not None and now.grid is not self._grid:
            if self._grid is None or _differ(self._grid, now.grid):
                mapped = survey(now.grid)
                # A map that grows or moves under the robot does not remove seen obstacles.
                self._layer = self._layer.over(mapped) if self._layer else self._no_marks(mapped)
                self._mapped, self._survey = mapped, mapped.with_obstacles(self._layer.marks)
            self._grid = now.grid
        if now.map_pose is not None:
            self._poses.remember(now.odom_stamp_s, now.map_pose)
        if now.scan is not None and now.scan is not self._scan:
            self._look(now.scan)

    @property
    def ready(self) -> bool:
        """Whether there is a map, and a scan that could be placed on it."""
        return self._survey is not None and self._scan is not None

    @property
    def seen_s(self) -> float | None:
        """Stamp of the newest scan that could be placed on the map, s."""
        return None if self._scan is None else self._scan.stamp_s

    @property
    def mapped(self) -> Survey:
        """The map alone."""
        assert self._mapped is not None
        return self._mapped

    @property
    def survey(self) -> Survey:
        """The map with seen obstacles; a new object whenever any cell changed."""
        assert self._survey is not None
        return self._survey

    @property
    def roads(self) -> RoadMap:
        """The road map of `survey`, made at first use."""
        if self._roads is None or self._roads.survey is not self.survey:
            self._roads = road_map(self.survey, self.cost)
        return self._roads

    def near(self, pose: Pose2D) -> Floats:
        """Return the hits of the newest scan within about a metre, seen from a pose, `n x 2` m."""
        return into_frame(pose, self._near_in_map)

    def show(self, path: Floats) -> None:
        """Publish a path that is driven from now on: points in the map, `n x 2` m."""
        self._publish({"poses": [Pose2D(x, y, 0.0) for x, y in path.tolist()]})

    def forget(self) -> None:
        """Drop seen obstacles, and start again from the map."""
        self._layer = self._no_marks(self.mapped)
        self._survey = self._mapped

    def _no_marks(self, mapped: Survey) -> ObstacleLayer:
        return ObstacleLayer(mapped, self.tuning.obstacle_memory)

    def _look(self, scan: Scan) -> None:
        pose = self._poses.at(scan.stamp_s)
        if pose is None or self._layer is None:
            return
        self._scan = scan
        hits = obstacle_points(scan, self._lidar).T
        in_map = out_of_frame(pose, hits)
        self._near_in_map = in_map[np.hypot(hits[:, 0], hits[:, 1]) < _NEAR_M]
        if self._layer.update(scan, in_map, composed(pose, self._mount)):
            self._survey = self.mapped.with_obstacles(self._layer.marks)


def _differ(old: Grid, new: Grid) -> bool:
    return (
        (old.resolution, old.origin_x, old.origin_y) != (new.resolution, new.origin_x, new.origin_y)
        or old.cells.shape != new.cells.shape
        or not np.array_equal(old.cells, new.cells)
    )
