"""The mapper as a ROS node: `map` out of `scan`, `odom` and `tf`, its coverage, and its files.

The files are those of Nav2's map server: a picture, and what its pixels mean.
"""

from __future__ import annotations

import array
import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from bt_mission_interfaces.msg import Coverage as CoverageMessage
from nav_msgs.msg import OccupancyGrid
from rclpy.qos import QoSProfile
from std_srvs.srv import Trigger

from action_servers.core.grid import OCCUPIED_FROM
from action_servers.core.maneuver import Grid, Scan
from action_servers.mapping.occupancy import FREE, OccupancyMapper
from action_servers.navigation.pose_history import PoseHistory
from action_servers.robot_io.sensors import LATCHED, SensorSubscriptions, SensorWiring
from bt_mission.base.errors import BtMissionError
from bt_mission.base.geometry import Pose2D
from bt_mission.base.goal_rate import MOST_WAITING, RateLimit
from bt_mission.base.output import write_file
from bt_mission.base.parameters import ParameterSpec, number
from bt_mission.robots.model import RobotModel, load_robot
from bt_mission.ros.executors.process import (
    NO_ARGUMENTS,
    ProcessOptions,
    RobotNode,
    RobotNodeOptions,
    run,
)

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


FREE_PIXEL, UNKNOWN_PIXEL, OCCUPIED_PIXEL = 254, 205, 0
"""Grey values of mode trinary, those of Nav2's map saver."""

OCCUPIED_THRESH, FREE_THRESH = 0.65, 0.196
"""Darkness, 0 to 1, from which a pixel is read as occupied, and below which as free.

Nav2's map saver writes 0.25 for the second; its map server then takes the grey of unknown cells, 1
- 205 / 255 = 0.19608, for free ones. 0.196 keeps them unknown.
"""


class MapFileError(BtMissionError):
    """A map cannot be written."""

    code = "BT-1103"


def save(grid: Grid, prefix: Path) -> tuple[Path, Path]:
    """Write `prefix`.pgm and `prefix`.yaml. Return both paths.

    Raises MapFileError for a map without cells, and if the files cannot be written.
    """
    if not grid.cells.size:
        raise MapFileError("there is no map yet: no scan has been placed on it")
    prefix = prefix.expanduser().absolute()
    picture, about = (prefix.with_name(f"{prefix.name}.{end}") for end in ("pgm", "yaml"))
    rows, columns = grid.cells.shape
    header = f"P5\n{columns} {rows}\n255\n".encode("ascii")
    try:
        prefix.parent.mkdir(parents=True, exist_ok=True)
        write_file(picture, header + pixels(grid).tobytes())
        write_file(about, _about(grid, picture.name))
    except (OSError, BtMissionError) as error:
        raise MapFileError(f"the map cannot be written to {prefix}: {error}") from error
    return picture, about


def pixels(grid: Grid) -> npt.NDArray[np.uint8]:
    """Return a map as grey values, `rows x columns`; the first row is that of the largest y."""
    grey = np.full(grid.cells.shape, UNKNOWN_PIXEL, dtype=np.uint8)
    grey[(grid.cells >= 0) & (grid.cells < OCCUPIED_FROM)] = FREE_PIXEL
    grey[grid.cells >= OCCUPIED_FROM] = OCCUPIED_PIXEL
    return grey[::-1]


def _about(grid: Grid, image: str) -> str:
    # A text in JSON is also one in YAML, whatever the file's name contains.
    return (
        f"image: {json.dumps(image)}\n"
        "mode: trinary\n"
        f"resolution: {grid.resolution:g}\n"
        f"origin: [{grid.origin_x:.6g}, {grid.origin_y:.6g}, 0.0]\n"
        "negate: 0\n"
        f"occupied_thresh: {OCCUPIED_THRESH}\n"
        f"free_thresh: {FREE_THRESH}\n"
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
