"""The mapper as a ROS node: a map out of `scan`, `odom` and `tf`, on the topic `map`."""

from __future__ import annotations

import array
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from bt_mission_interfaces.msg import Coverage as CoverageMessage
from nav_msgs.msg import OccupancyGrid
from rclpy.qos import QoSProfile
from std_srvs.srv import Trigger

from action_servers.core.maneuver import Grid, Scan
from action_servers.mapping.coverage import Measure, VisitedArea
from action_servers.mapping.files import MapFileError, save
from action_servers.mapping.occupancy import FREE, OccupancyMapper
from action_servers.navigation.senses import PoseHistory
from action_servers.robot_io.sensors import LATCHED, SensorSubscriptions, SensorWiring
from bt_mission.base.goal_rate import MOST_WAITING, RateLimit
from bt_mission.base.parameters import ParameterSpec, number
from bt_mission.robots.model import RobotModel, load_robot
from bt_mission.ros.executors.process import (
    NO_ARGUMENTS,
    ProcessOptions,
    RobotNode,
    RobotNodeOptions,
    run,
)

NODE_NAME = "bt_mission_mapper"
MAP_PREFIX = "map_prefix"

MOST_SAVES, SAVES_WINDOW_S = 5, 1.0
"""Maps that are saved within a time, s: meanwhile no scan is added."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MapperTuning:
    """The parameters of the mapper."""

    update_period: float = number(
        0.2,
        (0.05, 2.0),
        "How often a scan is added, s: every scan of an LDS-01, every other one of a Waffle in "
        "simulation.",
        is_fixed=True,
    )
    updates_per_map: int = number(
        5, (1, 100), "Updates from one map to the next; with the default period, one a second."
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class MapperOptions(RobotNodeOptions):
    """The options of the mapper. `map_prefix`: where `save_map` writes, .pgm and .yaml appended."""

    map_prefix: str = "map"


class MapperNode(RobotNode):
    """Publishes `map` (latched) and `coverage`, and offers `save_map`.

    The robot's pose is the transform of the map frame to odometry: another node localises, this one
    only maps. `map` is published when a cell is known to be free, then at most once a second, and
    only when it has changed; so is `coverage`.

    Args:
        robot: The pose and range of its lidar.
        options: All other options.

    Raises:
        rclpy.exceptions.ParameterException: A parameter is out of its range.
    """

    def __init__(self, robot: RobotModel, options: MapperOptions | None = None) -> None:
        options = options or MapperOptions()
        super().__init__(NODE_NAME, options)
        prefix = self.declare(
            MAP_PREFIX,
            ParameterSpec(
                options.map_prefix,
                "Where save_map writes; .pgm and .yaml are appended. A new value must lie in "
                "the folder that it had at first, or below.",
                is_fixed=False,
            ),
        )
        self._map_folder = Path(prefix).expanduser().resolve().parent
        self._tuning = self.declare_all(MapperTuning())
        self.add_post_set_parameters_callback(self._retune)
        self._mapper = OccupancyMapper(robot.lidar)
        self._coverage = VisitedArea()
        self._poses = PoseHistory()
        self._scan: Scan | None = None
        self._grid: Grid | None = None
        self._published: tuple[float, int] | None = None
        self._updates = 0
        wiring = self.declare_all(SensorWiring())
        self._sensors = SensorSubscriptions(self, wiring, robot, listen_to_map=False)
        self._map_frame = wiring.map_frame
        self._map_out = self.create_publisher(OccupancyGrid, wiring.map, LATCHED)
        self._coverage_out = self.create_publisher(CoverageMessage, "coverage", LATCHED)
        self._saves = RateLimit(SAVES_WINDOW_S, MOST_SAVES)
        self.create_service(
            Trigger, "save_map", self._save, qos_profile=QoSProfile(depth=MOST_WAITING)
        )
        self.create_timer(self._tuning.update_period, self._update)

    @property
    def grid(self) -> Grid | None:
        """The map as last published; None before."""
        return self._grid

    @property
    def measure(self) -> Measure:
        """The known and visited area, published or not."""
        return self._coverage.measure(self._mapper.grid())

    def _retune(self, _parameters: Any) -> None:
        self._tuning = self.read_all(MapperTuning())

    def _update(self) -> None:
        now = self._sensors.observe(on_map=True)
        if now.map_pose is not None:
            self._poses.remember(now.odom_stamp_s, now.map_pose)
            self._coverage.visit(now.map_pose)
        if now.scan is not None and now.scan is not self._scan:
            pose = self._poses.at(now.scan.stamp_s)
            if pose is not None:
                self._scan = now.scan
                if not self._mapper.add(now.scan, pose):
                    self._log.warning(
                        f"the robot, at ({pose.x:.1f}, {pose.y:.1f}) m, has left what one map "
                        "can hold; its scans are not added",
                        throttle_duration_sec=5.0,
                    )
        self._updates += 1
        if self._updates >= self._tuning.updates_per_map or self._grid is None:
            self._publish(now.time_s)

    def _publish(self, time_s: float) -> None:
        grid = self._mapper.grid(time_s)
        if not (grid.cells == FREE).any():
            return
        self._updates = 0
        if self._grid is None or not np.array_equal(grid.cells, self._grid.cells):
            self._grid = grid
            self._map_out.publish(self._map_message(grid))
        measure = self._coverage.measure(self._grid)
        if self._published != (measure.area, measure.zones_visited):
            self._published = (measure.area, measure.zones_visited)
            message = CoverageMessage(**asdict(measure))
            self._stamp(message.header)
            self._coverage_out.publish(message)

    def _map_message(self, grid: Grid) -> OccupancyGrid:
        message = OccupancyGrid()
        self._stamp(message.header)
        info = message.info
        info.map_load_time = message.header.stamp
        info.resolution = grid.resolution
        info.height, info.width = grid.cells.shape
        info.origin.position.x, info.origin.position.y = grid.origin_x, grid.origin_y
        message.data = array.array("b", grid.cells.tobytes())
        return message

    def _stamp(self, header: Any) -> None:
        header.frame_id = self._map_frame
        header.stamp = self.get_clock().now().to_msg()

    def _save(self, _request: Any, response: Any) -> Any:
        if not self._saves.admits(self.get_clock().now().nanoseconds):
            what = f"{MOST_SAVES} maps were saved within {SAVES_WINDOW_S:g} s"
            response.success, response.message = False, f"{what}, which is the limit"
            return response
        prefix = Path(self.get_parameter(MAP_PREFIX).value)
        try:
            self._refuse_other_folder(prefix)
            _, about = save(self._mapper.grid(), prefix)
        except MapFileError as error:
            response.success, response.message = False, str(error)
        else:
            response.success, response.message = True, f"map saved: {about}"
        return response

    def _refuse_other_folder(self, prefix: Path) -> None:
        """Raise MapFileError if a client asks for a file outside the folder."""
        if not prefix.expanduser().resolve().is_relative_to(self._map_folder):
            raise MapFileError(
                f"{MAP_PREFIX}: {prefix} is outside {self._map_folder}, the folder of the "
                f"mapper; restart it with another --save-as"
            )


def main(
    *,
    robot: str,
    namespace: str = "",
    use_sim_time: bool = False,
    map_prefix: str = "map",
    process: ProcessOptions = NO_ARGUMENTS,
) -> int:
    """Map until SIGINT or SIGTERM. Returns the exit code 0.

    `robot` is a name or a path. Raises BtMissionError for a robot or a parameter file that cannot
    be used.
    """
    model = load_robot(robot)
    options = MapperOptions(namespace=namespace, use_sim_time=use_sim_time, map_prefix=map_prefix)
    return run(NODE_NAME, process, options, lambda options: MapperNode(model, options))
