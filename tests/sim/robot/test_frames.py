"""The tree of frames, as the URDF of a TurtleBot3 has it."""

import math

import pytest

from bt_mission.core.robot.model import load_robot
from sim.frames import map_to_odom
from sim.robot.frames import fixed_frames

WAFFLE, BURGER = load_robot("waffle"), load_robot("burger")


def test_waffle_has_every_frame_of_its_urdf_once():
    """One tree below base_footprint, down to the camera's optical frame."""
    frames = {frame.child: frame for frame in fixed_frames(WAFFLE)}
    assert len(frames) == len(fixed_frames(WAFFLE))
    assert {child: frame.parent for child, frame in frames.items()} == {
        "base_link": "base_footprint",
        "wheel_left_link": "base_link",
        "wheel_right_link": "base_link",
        "caster_back_left_link": "base_link",
        "caster_back_right_link": "base_link",
        "imu_link": "base_link",
        "base_scan": "base_link",
        "camera_link": "base_link",
        "camera_rgb_frame": "camera_link",
        "camera_rgb_optical_frame": "camera_rgb_frame",
    }


def test_frames_stand_where_the_urdf_puts_them():
    """Base, lidar, wheels and camera, in metres in their parents."""
    at = {frame.child: frame.translation for frame in fixed_frames(WAFFLE)}
    assert at["base_link"] == pytest.approx((0, 0, 0.010))
    assert at["base_scan"] == pytest.approx((-0.064, 0, 0.122))
    assert at["wheel_left_link"] == pytest.approx((0, 0.144, 0.023))
    assert at["camera_rgb_frame"] == pytest.approx((0.005, 0.018, 0.013))


def test_burger_has_one_caster_and_no_camera():
    """Its caster's frame has no side in its name."""
    children = {frame.child for frame in fixed_frames(BURGER)}
    assert "caster_back_link" in children
    assert not any("camera" in child for child in children)


def test_rotations_are_unit_quaternions():
    """x, y, z, w of length 1."""
    for frame in fixed_frames(WAFFLE):
        assert math.hypot(*frame.rotation) == pytest.approx(1)


def test_map_to_odom_takes_odometry_to_the_truth():
    """Odometry's pose, seen through map to odom, is the true pose."""
    pose, odom = (1.0, 2.0, 0.7), (0.3, -0.4, -0.2)
    x, y, yaw = map_to_odom(pose, odom)
    assert x + math.cos(yaw) * odom[0] - math.sin(yaw) * odom[1] == pytest.approx(pose[0])
    assert y + math.sin(yaw) * odom[0] + math.cos(yaw) * odom[1] == pytest.approx(pose[1])
    assert yaw + odom[2] == pytest.approx(pose[2])
