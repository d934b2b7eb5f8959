"""Every kind of sensor, in the order in which they measure at one instant."""

from __future__ import annotations

from bt_mission.core.robot.model import RobotModel
from sim.sensors.battery import BatterySensor
from sim.sensors.camera import CameraInfoSensor, CameraSensor
from sim.sensors.imu import Imu
from sim.sensors.lidar import LidarSensor, further_lidar
from sim.sensors.sensor import Sensor

SENSORS: tuple[type[Sensor], ...] = (
    Imu,
    LidarSensor,
    BatterySensor,
    CameraInfoSensor,
    CameraSensor,
)


def sensors_of(robot: RobotModel) -> list[type[Sensor]]:
    """Return the kinds of sensors that a robot has."""
    kinds = [kind for kind in SENSORS if kind.figures(robot) is not None]
    return [*kinds, *map(further_lidar, robot.lidars)]
