"""Every kind of sensor, in the order in which they measure at one instant."""

from __future__ import annotations

from bt_mission.robots.model import RobotModel
from sim.sensors.battery import BatterySensor
from sim.sensors.bumper import BumperSensor
from sim.sensors.camera import CameraInfoSensor, CameraSensor
from sim.sensors.depth_camera import DepthCameraSensor, DepthInfoSensor
from sim.sensors.distance import RangeSensor
from sim.sensors.imu import Imu
from sim.sensors.lidar import LidarSensor
from sim.sensors.sensor import Sensor, named

SENSORS: tuple[type[Sensor], ...] = (
    Imu,
    LidarSensor,
    BatterySensor,
    CameraInfoSensor,
    CameraSensor,
    DepthInfoSensor,
    DepthCameraSensor,
)

NAMED: tuple[type[Sensor], ...] = (LidarSensor, RangeSensor, BumperSensor)
"""Those of which a robot has several, each with a name."""


def sensors_of(robot: RobotModel) -> list[type[Sensor]]:
    """Return the kinds of sensors that a robot has."""
    kinds = [kind for kind in SENSORS if kind.figures(robot) is not None]
    return kinds + [named(kind, name) for kind in NAMED for name in getattr(robot, kind.table)]
