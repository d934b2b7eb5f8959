"""The mapper as a ROS node: a map out of `scan`, `odom` and `tf`, on the topic `map`."""

from __future__ import annotations

import array
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import rclpy
from bt_mission_interfaces.msg import Coverage as CoverageMessage
from nav_msgs.msg import OccupancyGrid
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.executors import SingleThreadedExecutor
from rclpy.logging import LoggingSeverity
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from std_srvs.srv import Trigger

from action_servers.core.maneuver import Grid, Scan
from action_servers.mapping.coverage import Measure, VisitedArea
from action_servers.mapping.files import MapFileError, save
from action_servers.mapping.occupancy import FREE, OccupancyMapper
from action_servers.mapping.tuning import MapperTuning
from action_servers.navigation.history import PoseHistory
from action_servers.robot_io.interrupts import SignalNote
from action_servers.robot_io.node_parameters import declare, made_with, overrides
from action_servers.robot_io.parameter_file import read_parameters
from action_servers.robot_io.robot_settings import listening, sensor_settings
from action_servers.robot_io.sensors import LATCHED, SensorSubscriptions
from action_servers.robot_io.tuning_parameters import declare_tuning
from bt_mission.core.robot.model import RobotModel, load_robot

if TYPE_CHECKING:
    from rclpy.context import Context

NODE_NAME = "bt_mission_mapper"
MAP_PREFIX = "map_prefix"


class MapperNode(Node):
    """Publishes `map` (latched) and `coverage`, and offers `save_map`.

    The robot's place comes from the transform of the map frame to odometry: something else
    localises, this only maps. `map` is published when anything is known to be free, then at most
    once a second, and only when it has changed; `coverage` too, when it has.

    :param robot: place and reach of its lidar.
    :param lean: no parameter services, log topic or type description, and only warnings in the
        log, as on the stage.
    :param context: the rclpy context; None is the default one.
    :param use_sim_time: follow `/clock`.
    :param map_prefix: where `save_map` writes, `.pgm` and `.yaml` appended.
    :param parameters: values of parameters by name, instead of their defaults.
    :raises rclpy.exceptions.ParameterException: for a parameter out of its range.
    """

    def __init__(
        self,
        robot: RobotModel,
        *,
        lean: bool = False,
        context: Context | None = None,
        namespace: str | None = None,
        use_sim_time: bool = False,
        map_prefix: str = "map",
        parameters: Mapping[str, Any] | None = None,
    ) -> None:
        super().__init__(
            NODE_NAME,
            context=context,
            namespace=namespace,
            enable_rosout=not lean,
            start_parameter_services=not lean,
            parameter_overrides=[
                Parameter("use_sim_time", value=use_sim_time),
                Parameter("start_type_description_service", value=not lean),
                *overrides(parameters or {}),
            ],
        )
        if lean:
            _log(self).set_level(LoggingSeverity.WARN)
        self.declare_parameter(
            MAP_PREFIX,
            map_prefix,
            ParameterDescriptor(description="Where save_map writes; .pgm and .yaml are appended."),
        )
        self._tuning = declare_tuning(self, MapperTuning)
        self._mapper = OccupancyMapper(robot.lidar)
        self._coverage = VisitedArea()
        self._poses = PoseHistory()
        self._scan: Scan | None = None
        self._grid: Grid | None = None
        self._told: tuple[float, int] | None = None
        self._updates = 0
        wiring = listening(declare(self, sensor_settings()))
        self._sensors = SensorSubscriptions(self, wiring, robot.lidar, listen_to_map=False)
        self._map_frame = wiring.map_frame
        self._map_out = self.create_publisher(OccupancyGrid, wiring.topics.map, LATCHED)
        self._coverage_out = self.create_publisher(CoverageMessage, "coverage", LATCHED)
        self.create_service(Trigger, "save_map", self._save)
        self.create_timer(self._tuning.update_period, self._update)

    @property
    def grid(self) -> Grid | None:
        """The map as it was last published; None before."""
        return self._grid

    @property
    def measure(self) -> Measure:
        """What is known and visited by now, published or not."""
        return self._coverage.measure(self._mapper.grid())

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
                    _log(self).warning(
                        f"the robot, at ({pose.x:.1f}, {pose.y:.1f}) m, has left what one map "
                        "can hold; its scans are not added",
                        throttle_duration_sec=5.0,
                    )
        self._updates += 1
        if self._updates >= self._tuning.updates_per_map or self._grid is None:
            self._tell(now.time_s)

    def _tell(self, time_s: float) -> None:
        grid = self._mapper.grid(time_s)
        if not (grid.cells == FREE).any():
            return
        self._updates = 0
        if self._grid is None or not np.array_equal(grid.cells, self._grid.cells):
            self._grid = grid
            self._map_out.publish(self._map_message(grid))
        measure = self._coverage.measure(self._grid)
        if self._told != (measure.area, measure.zones_visited):
            self._told = (measure.area, measure.zones_visited)
            message = CoverageMessage(
                area=measure.area,
                fraction=measure.fraction,
                zones_visited=measure.zones_visited,
                zones=measure.zones,
            )
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
        prefix = Path(self.get_parameter(MAP_PREFIX).value)
        try:
            _, about = save(self._mapper.grid(), prefix)
        except MapFileError as error:
            response.success, response.message = False, str(error)
        else:
            response.success, response.message = True, f"map saved: {about}"
        return response


def _log(node: Node) -> Any:
    return node.get_logger()


def main(
    *,
    robot: str,
    namespace: str = "",
    use_sim_time: bool = False,
    map_prefix: str = "map",
    parameters: Path | None = None,
) -> int:
    """Map until SIGINT or SIGTERM. Returns the exit code 0.

    `robot` is a name or a path, `parameters` a ROS parameter file; raises BtMissionError for one
    that cannot be used.
    """
    model = load_robot(robot)
    file = None if parameters is None else read_parameters(parameters, NODE_NAME)
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = made_with(
            file,
            lambda values: MapperNode(
                model,
                namespace=namespace,
                use_sim_time=use_sim_time,
                map_prefix=map_prefix,
                parameters=values,
            ),
        )
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        with SignalNote() as interrupts:
            while not interrupts.received:
                executor.spin_once(timeout_sec=0.1)
        executor.shutdown()
        node.destroy_node()  # type: ignore[no-untyped-call]
    finally:
        rclpy.try_shutdown()
    return 0
