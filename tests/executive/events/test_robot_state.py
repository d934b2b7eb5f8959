"""Where a robot is, and what it sees, from frames and readings."""

from __future__ import annotations

import math

import pytest

from bt_mission.base.geometry import Pose2D
from bt_mission.executive.events.messages import BatteryState, FrameTransform, ScanPoints
from bt_mission.executive.events.robot_state import RobotState

QUARTER = math.pi / 2


def at(x: float, y: float, yaw: float = 0.0) -> tuple[FrameTransform, ...]:
    """The base of a robot that is localised on a map."""
    return (
        FrameTransform("map", "odom", 1.0, 0.0, QUARTER),
        FrameTransform("odom", "base_footprint", x, y, yaw),
    )


def test_frames_are_joined_from_the_root():
    """A step ahead in a frame that is turned left is a step to the left."""
    robot = RobotState()
    robot.take(at(2.0, 0.0))
    pose = robot.pose
    assert pose is not None
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((1.0, 2.0, QUARTER))
    assert robot.frame == "map"


@pytest.mark.parametrize(
    ("frames", "pose"),
    [
        ((FrameTransform("odom", "robot1/base_link", 3.0, 4.0, 0.0),), Pose2D(3.0, 4.0, 0.0)),
        (
            (FrameTransform("a", "base_link", 0, 0, 0), FrameTransform("base_link", "a", 0, 0, 0)),
            Pose2D(0.0, 0.0, 0.0),
        ),
    ],
    ids=["a prefix, as robots of a fleet may have", "a circle"],
)
def test_frames_of_other_robots(frames: tuple[FrameTransform, ...], pose: Pose2D):
    """A broken tree of frames hangs nobody's view."""
    robot = RobotState()
    robot.take(frames)
    assert robot.pose == pose


def test_the_trail_grows_as_the_robot_moves():
    """Not while it stands; a robot that becomes localised begins a new one."""
    robot = RobotState()
    for step in range(10):
        robot.take((FrameTransform("odom", "base_footprint", 0.02 * step, 0.0, 0.0),))
    assert (len(robot.trail), robot.frame) == (4, "odom")
    robot.take(at(0.2, 0.0))
    assert (len(robot.trail), robot.frame) == (1, "map")


def test_a_scan_is_seen_from_its_own_frame():
    """Rays without an echo, and those that are not numbers, are left out."""
    robot = RobotState()
    rays = (1.0, math.inf, math.nan, 0.05, 2.0)
    robot.take(ScanPoints("base_scan", 0.0, QUARTER, 0.1, 3.5, rays))
    assert robot.scan_points() == [], "its frame is not known"
    robot.take(at(0.0, 0.0))
    robot.take((FrameTransform("base_footprint", "base_scan", 0.1, 0.0, 0.0),))
    first, last = robot.scan_points()
    assert first == pytest.approx((1.0, 1.1))
    assert last == pytest.approx((1.0, 2.1))


@pytest.mark.parametrize(
    ("charges", "percent"), [([0.5], 50), ([87.0], 87), ([87.0, 0.9], 0.9), ([math.nan], None)]
)
def test_a_battery_has_percent(charges: list[float], percent: float | None):
    """A share of one by the message's definition, 0 to 100 on a TurtleBot3, which is remembered."""
    robot = RobotState()
    assert robot.charge is None
    for charge in charges:
        robot.take(BatteryState(charge, 12.0))
    assert robot.charge == percent
