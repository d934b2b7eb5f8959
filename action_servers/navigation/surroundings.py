"""The state of the world for navigation: map, seen obstacles, and recent poses."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from action_servers.core.action import PublishedTopic
from action_servers.core.clearance import into_frame, obstacle_points, out_of_frame
from action_servers.core.grid import Floats, Survey, survey
from action_servers.core.maneuver import Fields, Grid, Observation, Scan
from action_servers.navigation.obstacles import ObstacleLayer
from action_servers.navigation.path import CostModel, cost_model
from action_servers.navigation.planner import RoadMap, road_map
from action_servers.navigation.senses import PoseHistory
from action_servers.navigation.tuning import NAVIGATION, NavigationTuning
from bt_mission.base.geometry import Pose2D, composed
from bt_mission.robots.model import RobotModel

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
