"""The robot's frames as its URDF has them: names, and where each stands in its parent."""

from __future__ import annotations

import math
from dataclasses import dataclass

from bt_mission.core.robot.model import RobotModel

MAP = "map"
ODOM = "odom"
BASE_FOOTPRINT = "base_footprint"
BASE_LINK = "base_link"
IMU_LINK = "imu_link"
SCAN_FRAME = "base_scan"
CAMERA_LINK = "camera_link"
CAMERA_FRAME = "camera_rgb_frame"
CAMERA_OPTICAL_FRAME = "camera_rgb_optical_frame"
WHEEL_JOINTS = ("wheel_left_joint", "wheel_right_joint")

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

_AHEAD: Quaternion = (0.0, 0.0, 0.0, 1.0)
# A quarter turn about x to the right: z along the axle to the left.
_SIDEWAYS: Quaternion = (-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
# REP 103: z into the picture, x to its right, y down.
_OPTICAL: Quaternion = (-0.5, 0.5, -0.5, 0.5)


@dataclass(frozen=True)
class FramePose:
    """A frame in its parent: translation in m, rotation as x, y, z, w."""

    parent: str
    child: str
    translation: Vector
    rotation: Quaternion = _AHEAD


def fixed_frames(robot: RobotModel) -> list[FramePose]:
    """Return everything below `base_footprint`. Wheels are shown as they stand at the start."""
    axle_z = robot.wheel_radius - robot.base_height
    lidar, imu, camera = robot.lidar, robot.imu, robot.camera
    frames = [
        FramePose(BASE_FOOTPRINT, BASE_LINK, (0.0, 0.0, robot.base_height)),
        FramePose(BASE_LINK, "wheel_left_link", (0.0, robot.wheel_y, axle_z), _SIDEWAYS),
        FramePose(BASE_LINK, "wheel_right_link", (0.0, -robot.wheel_y, axle_z), _SIDEWAYS),
        *(FramePose(BASE_LINK, _caster(at), at, _SIDEWAYS) for at in robot.casters),
        FramePose(BASE_LINK, IMU_LINK, (imu.x, imu.y, imu.z)),
        FramePose(BASE_LINK, SCAN_FRAME, (lidar.x, lidar.y, lidar.z)),
    ]
    if camera is not None:
        x, y, z = camera.link
        lens = (camera.x - x, camera.y - y, camera.z - z)
        frames += [
            FramePose(BASE_LINK, CAMERA_LINK, camera.link),
            FramePose(CAMERA_LINK, CAMERA_FRAME, lens),
            FramePose(CAMERA_FRAME, CAMERA_OPTICAL_FRAME, (0.0, 0.0, 0.0), _OPTICAL),
        ]
    return frames


def map_to_odom(pose: Vector, odom: Vector) -> Vector:
    """Return the odometry frame's pose in the map (m, m, rad), from the base's pose in both."""
    yaw = pose[2] - odom[2]
    cos, sin = math.cos(yaw), math.sin(yaw)
    x = pose[0] - (cos * odom[0] - sin * odom[1])
    y = pose[1] - (sin * odom[0] + cos * odom[1])
    return x, y, yaw


def _caster(at: Vector) -> str:
    side = "_left" if at[1] > 0 else "_right" if at[1] < 0 else ""
    return f"caster_back{side}_link"
