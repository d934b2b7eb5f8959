"""The servers on a bench: real rclpy, virtual time, a fake robot."""

from __future__ import annotations

import pytest

from bt_mission.robots.model import load_robot
from tests.support import served
from tests.support.bench import Bench
from tests.support.fake_robot import FakeRobot
from tests.support.robot_node import RobotNode, pose


@pytest.fixture
def bench(tmp_path):
    """A bench whose robot has been heard of."""
    made = Bench(FakeRobot(load_robot("waffle")), tmp_path / "images")
    made.steps(2)
    yield made
    made.close()


@pytest.fixture
def silent_bench(tmp_path):
    """A bench whose robot has not said anything yet."""
    made = Bench(FakeRobot(load_robot("waffle")), tmp_path / "images")
    made.robot.silent = {"scan", "odom", "tf", "camera"}
    made.steps(2)
    yield made
    made.close()


@pytest.fixture(name="goal")
def goal_():
    """Make a sound goal that takes several seconds: `goal(name, **changes)`."""
    return served.goal


@pytest.fixture(name="pose")
def pose_():
    """Make a pose on the map: `pose(x, y, yaw_deg)`."""
    return pose


@pytest.fixture
def robot_node():
    """Make a fake robot's node: `robot_node(fake, context, start_ns)`."""
    return RobotNode
