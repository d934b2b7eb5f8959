"""What sensors declare, in messages: frames, constants, and the numbers that change."""

import math

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from rclpy.serialization import deserialize_message, serialize_message

from bt_mission.base.files import names
from bt_mission.robots.model import load_robot
from sim.robot.description import sensors_of
from sim.ros.sensor_topics import empty_message
from sim.sensors.camera import CameraInfoSensor
from sim.sensors.imu import Imu
from sim.sensors.lidar import LidarSensor
from sim.sensors.topics import topics_of
from tests.support.simulated import alone

KINDS = {
    kind.topic: kind for name in ("turtlebot4", "rosbot") for kind in sensors_of(load_robot(name))
}


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_a_message_has_stamp_and_frame_and_can_be_sent(make_world, kind):
    """One stamp, changed once, dates all messages."""
    stamp = Time()
    robot = load_robot("rosbot" if kind.figures(load_robot("rosbot")) else "turtlebot4")
    message = empty_message(alone(make_world(), robot).sensor(kind), stamp)
    stamp.sec = 7
    received = deserialize_message(serialize_message(message), type(message))
    if hasattr(received, "header"):
        assert (received.header.stamp.sec, received.header.frame_id) == (7, kind.frame)
    else:
        assert received == message


def test_an_inertial_reading_has_w_last(simulate):
    """Attitude as the message has it; rates and accelerations by axis."""
    imu = simulate().sensor(Imu)
    reading = imu.measure(3)
    w, *axes = reading.orientation
    numbers = (*axes, w, *reading.angular_velocity, *reading.linear_acceleration)
    assert imu.numbers(3) == numbers
    assert imu.fields[3:5] == ("orientation.w", "angular_velocity.x")


def test_inertial_covariances_are_variances_on_the_diagonal(simulate):
    """Independent axes, the noise of the model squared."""
    message = empty_message(simulate().sensor(Imu), Time())
    expected = np.diag([1.7e-2**2] * 3).ravel()
    assert message.linear_acceleration_covariance == pytest.approx(expected)
    assert message.angular_velocity_covariance[4] == pytest.approx(4e-8)


def test_scan_covers_a_full_turn_less_one_step(simulate):
    """360 rays from 0, as the driver of the LDS-01 sends them."""
    message = empty_message(simulate().sensor(LidarSensor), Time())
    assert message.angle_min == 0
    assert message.angle_increment == pytest.approx(math.radians(1))
    assert message.angle_max == pytest.approx(math.radians(359))
    assert (message.range_min, message.range_max) == pytest.approx((0.12, 3.5))
    assert len(message.ranges) == 360


def test_camera_info_is_a_pinhole(simulate):
    """The focal length follows from the field of view; the centre is the middle."""
    message = empty_message(simulate().sensor(CameraInfoSensor), Time())
    focal = 160 / math.tan(1.02974 / 2)
    assert message.k == pytest.approx([focal, 0, 160, 0, focal, 120, 0, 0, 1])
    assert message.p == pytest.approx([focal, 0, 160, 0, 0, focal, 120, 0, 0, 0, 1, 0])
    assert (message.distortion_model, list(message.d)) == ("plumb_bob", [0.0] * 5)


@pytest.mark.parametrize("name", names("robots"))
def test_the_topics_of_a_robot_are_known_without_its_sensors(name):
    """`check` looks for them without loading MuJoCo."""
    robot = load_robot(name)
    assert topics_of(robot) == {kind.topic for kind in sensors_of(robot)}


def test_a_robot_without_a_camera_has_the_other_sensors():
    """A Burger."""
    assert {kind.name for kind in sensors_of(load_robot("burger"))} == {"imu", "lidar", "battery"}
