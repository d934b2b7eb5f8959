"""The topics of a robot's sensors. MuJoCo, which the sensors import, is not needed to know them."""

from __future__ import annotations

from bt_mission.robots.model import RobotModel

BATTERY_STATE = "battery_state"
BUMPER = "bumper"
CAMERA_IMAGE = "camera/image_raw"
CAMERA_INFO = "camera/camera_info"
DEPTH_IMAGE = "camera/depth/image_rect_raw"
DEPTH_INFO = "camera/depth/camera_info"
IMU = "imu"
RANGE = "range"
SCAN = "scan"

_OF_PARTS = {
    "battery": (BATTERY_STATE,),
    "camera": (CAMERA_INFO, CAMERA_IMAGE),
    "depth_camera": (DEPTH_INFO, DEPTH_IMAGE),
    "imu": (IMU,),
    "lidar": (SCAN,),
}
"""By the field of `RobotModel` that has the figures; None is a robot without the sensor."""

_OF_TABLES = {"bumpers": BUMPER, "lidars": SCAN, "range_sensors": RANGE}
"""By the field of `RobotModel` that has several sensors by their names."""


def topic_of(kind: str, name: str) -> str:
    """Return the topic of one of several sensors, from that of its kind and its name."""
    return f"{kind}_{name}"


def topics_of(robot: RobotModel) -> frozenset[str]:
    """Return the topics of all sensors that a robot has."""
    topics = [_OF_PARTS[part] for part in _OF_PARTS if getattr(robot, part) is not None]
    for table, kind in _OF_TABLES.items():
        topics.append(tuple(topic_of(kind, name) for name in getattr(robot, table)))
    return frozenset(topic for of_part in topics for topic in of_part)
