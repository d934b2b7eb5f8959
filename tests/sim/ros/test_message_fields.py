"""Readings in messages: every field that is filled, on plain stand-ins for the messages."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from bt_mission.core.robot.model import load_robot
from bt_mission.core.robot.parts import CameraModel
from sim.physics.contacts import Collision
from sim.robot.frames import FramePose
from sim.ros import message_fields
from sim.sensors.imu import Inertial

WAFFLE = load_robot("waffle")
CAMERA = CameraModel.model_validate(WAFFLE.camera)


class Message(SimpleNamespace):
    """Takes any field; an unknown one is another message."""

    def __getattr__(self, name: str) -> "Message":
        if name.startswith("__"):
            raise AttributeError(name)
        inner = Message()
        setattr(self, name, inner)
        return inner


def test_header_shares_the_stamp():
    """One stamp, changed once, dates all messages."""
    stamp, message = Message(), Message()
    assert message_fields.header(message, stamp, "odom", "base_footprint") is message
    assert message.header.stamp is stamp
    assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_footprint")


def test_fixed_transform():
    """Parent, child, place and rotation."""
    frame = FramePose("base_link", "base_scan", (-0.064, 0.0, 0.122))
    message = message_fields.transform(Message(), frame, Message())
    at = message.transform
    assert (message.header.frame_id, message.child_frame_id) == ("base_link", "base_scan")
    assert (at.translation.x, at.translation.y, at.translation.z) == (-0.064, 0.0, 0.122)
    assert (at.rotation.x, at.rotation.y, at.rotation.z, at.rotation.w) == (0, 0, 0, 1)


def test_a_place_on_the_floor():
    """Yaw as a turn about z."""
    x, y, z, w = message_fields.planar(1.0, 2.0, math.pi / 2)
    assert (x, y) == (1, 2)
    assert (z, w) == pytest.approx((math.sqrt(0.5),) * 2)


def test_inertial_reading():
    """Attitude with w last, as the message has it; rates and accelerations by axis."""
    reading = Inertial((1.0, 0.0, 0.1, 0.2), (0.3, 0.4, 0.5), (0.6, 0.7, 9.8))
    assert message_fields.inertial(reading) == (0.0, 0.1, 0.2, 1, 0.3, 0.4, 0.5, 0.6, 0.7, 9.8)


def test_inertial_limits_are_variances_on_the_diagonal():
    """Independent axes, the noise of the model squared."""
    message = Message(
        angular_velocity_covariance=np.zeros(9), linear_acceleration_covariance=np.zeros(9)
    )
    message_fields.inertial_limits(message, WAFFLE.imu)
    expected = np.diag([1.7e-2**2] * 3).ravel()
    assert message.linear_acceleration_covariance == pytest.approx(expected)
    assert message.angular_velocity_covariance[4] == pytest.approx(4e-8)


def test_scan_covers_a_full_turn_less_one_step():
    """360 rays from 0, as the driver of the LDS-01 sends them; ranges are written in place."""
    message = Message()
    ranges = message_fields.scan_limits(message, WAFFLE.lidar)
    assert message.angle_min == 0
    assert message.angle_increment == pytest.approx(math.radians(1))
    assert message.angle_max == pytest.approx(math.radians(359))
    assert (message.range_min, message.range_max) == (0.12, 3.5)
    ranges[7] = 1.5
    assert message.ranges[7] == 1.5
    assert message.ranges.typecode == "f"


def test_image_is_rgb8_and_written_in_place():
    """Three bytes a pixel, top row first."""
    message = Message()
    pixels = message_fields.image_format(message, CAMERA)
    assert (message.width, message.height, message.encoding, message.step) == (
        320,
        240,
        "rgb8",
        960,
    )
    pixels[1, 2] = (7, 8, 9)
    assert message.data[966:969].tolist() == [7, 8, 9]


def test_camera_info_is_a_pinhole():
    """The focal length follows from the field of view; the centre is the middle."""
    message = Message()
    message_fields.camera_info(message, CAMERA)
    focal = 160 / math.tan(1.02974 / 2)
    assert message.k == pytest.approx([focal, 0, 160, 0, focal, 120, 0, 0, 1])
    assert message.p == pytest.approx([focal, 0, 160, 0, 0, focal, 120, 0, 0, 0, 1, 0])
    assert (message.distortion_model, message.d) == ("plumb_bob", [0.0] * 5)


def test_collision_has_the_time_of_its_onset():
    """In the map frame, with name, place and force."""
    message = Message()
    message_fields.collision(message, Collision(2_500_000_000, "pillar", (1.0, 2.0, 0.1), 7.5))
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (2, 500_000_000)
    assert (message.header.frame_id, message.obstacle, message.force) == ("map", "pillar", 7.5)
    assert (message.point.x, message.point.y, message.point.z) == (1, 2, 0.1)
