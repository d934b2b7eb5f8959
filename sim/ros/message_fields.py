"""Writes readings into ROS messages that were made once and are sent again and again.

The messages are handed in, so nothing here needs ROS. Arrays inside a message are written in
place through `view`, which costs a tenth of handing over a list.
"""

from __future__ import annotations

import array
import math
from typing import Any

import numpy as np
import numpy.typing as npt

from bt_mission.core.robot.parts import BatteryModel as BatterySpec
from bt_mission.core.robot.parts import CameraModel, LidarModel
from bt_mission.core.robot.parts import ImuModel as ImuSpec
from bt_mission.core.stamps import set_ns
from sim.physics.contacts import Collision
from sim.robot.frames import MAP, FramePose
from sim.sensors.battery import Battery
from sim.sensors.imu import Inertial


def view(values: array.array[Any], dtype: npt.DTypeLike) -> npt.NDArray[Any]:
    """Return a NumPy array over the same memory."""
    return np.frombuffer(values, dtype=dtype)


def header(message: Any, stamp: Any, frame: str, child: str | None = None) -> Any:
    """Give a message its frames, and a stamp that others may share; returns the message."""
    message.header.stamp, message.header.frame_id = stamp, frame
    if child is not None:
        message.child_frame_id = child
    return message


def transform(message: Any, frame: FramePose, stamp: Any) -> Any:
    """Fill a TransformStamped with a fixed frame, and return it."""
    header(message, stamp, frame.parent, frame.child)
    t, r = message.transform.translation, message.transform.rotation
    t.x, t.y, t.z = frame.translation
    r.x, r.y, r.z, r.w = frame.rotation
    return message


def collision(message: Any, event: Collision) -> Any:
    """Fill a Collision, stamped with its own time, and return it."""
    set_ns(message.header.stamp, event.time_ns)
    message.header.frame_id = MAP
    message.obstacle, message.force = event.obstacle, event.force
    message.point.x, message.point.y, message.point.z = event.point
    return message


def planar(x: float, y: float, yaw: float) -> tuple[float, float, float, float]:
    """Return x and y of a place, and z and w of its quaternion."""
    return x, y, math.sin(yaw / 2.0), math.cos(yaw / 2.0)


def inertial(reading: Inertial) -> tuple[float, ...]:
    """Return the numbers of an Imu, in its order: the quaternion's w comes last."""
    w, *axes = reading.orientation
    return (*axes, w, *reading.angular_velocity, *reading.linear_acceleration)


def inertial_limits(message: Any, spec: ImuSpec) -> None:
    """Fill the covariances of an Imu: independent axes."""
    for covariance, sigma in (
        (message.angular_velocity_covariance, spec.gyro_noise),
        (message.linear_acceleration_covariance, spec.accel_noise),
    ):
        covariance[[0, 4, 8]] = sigma**2


def scan_limits(message: Any, spec: LidarModel) -> npt.NDArray[np.float32]:
    """Fill the constant part of a LaserScan, and return a view of its ranges.

    As the driver of the LDS-01 has it: 0 to one step before a full turn. All rays are measured
    at one instant, so the times between them are 0. The driver of the LDS-02 says that ranges
    reach from 0 to 100 m, whatever the sensor can.
    """
    step = math.tau / spec.rays
    message.angle_min, message.angle_max = 0.0, step * (spec.rays - 1)
    message.angle_increment = step
    lds_01 = spec.model == "LDS-01"
    message.range_min, message.range_max = (
        (spec.min_range, spec.max_range) if lds_01 else (0.0, 100.0)
    )
    message.ranges = array.array("f", bytes(4 * spec.rays))
    return view(message.ranges, np.float32)


def scan_of(message: Any, ranges: npt.NDArray[np.float32]) -> None:
    """Fill a LaserScan with a full turn of any number of rays."""
    step = math.tau / len(ranges)
    message.angle_max, message.angle_increment = step * (len(ranges) - 1), step
    message.ranges = array.array("f", ranges.tobytes())


def battery_limits(message: Any, spec: BatterySpec) -> None:
    """Fill the constant part of a BatteryState."""
    message.design_capacity = spec.capacity
    message.temperature = message.capacity = math.nan  # not measured, as the message has it
    message.power_supply_status = 2  # POWER_SUPPLY_STATUS_DISCHARGING
    message.power_supply_technology = 3  # POWER_SUPPLY_TECHNOLOGY_LIPO
    message.present = True


def charge(state: Battery) -> tuple[float, float, float, float]:
    """Return V, A (below 0: discharging), Ah, and a percentage from 0 to 100."""
    return state.voltage, -state.current, state.charge * state.spec.capacity, state.percentage


def image_format(message: Any, spec: CameraModel) -> npt.NDArray[np.uint8]:
    """Fill the constant part of an Image, and return a view of its pixels, rows x columns x 3."""
    message.width, message.height = spec.width, spec.height
    message.encoding, message.step = "rgb8", 3 * spec.width
    message.data = array.array("B", bytes(3 * spec.width * spec.height))
    return view(message.data, np.uint8).reshape(spec.height, spec.width, 3)


def camera_info(message: Any, spec: CameraModel) -> None:
    """Fill a CameraInfo: a pinhole without distortion, square pixels, centre in the middle."""
    focal = spec.width / (2 * math.tan(spec.hfov / 2))
    cx, cy = spec.width / 2, spec.height / 2
    message.width, message.height = spec.width, spec.height
    message.distortion_model, message.d = "plumb_bob", [0.0] * 5
    message.k = [focal, 0.0, cx, 0.0, focal, cy, 0.0, 0.0, 1.0]
    message.r = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    message.p = [focal, 0.0, cx, 0.0, 0.0, focal, cy, 0.0, 0.0, 0.0, 1.0, 0.0]
