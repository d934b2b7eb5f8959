"""Robots and scans for maneuvers without ROS and without MuJoCo, and servers on a bench."""

from __future__ import annotations

import math

import numpy as np
import pytest

from action_servers.core.maneuver import Scan
from bt_mission.robots.model import RobotModel, load_robot
from tests.support.bench_fixtures import bench, goal_, pose_, robot_node, silent_bench
from tests.support.fake_robot import FakeRobot

__all__ = ["bench", "goal_", "pose_", "robot_node", "silent_bench"]


@pytest.fixture(params=["waffle", "burger"])
def robot(request: pytest.FixtureRequest) -> RobotModel:
    """Each robot we ship."""
    return load_robot(request.param)


@pytest.fixture
def waffle() -> RobotModel:
    """The robot with a camera."""
    return load_robot("waffle")


@pytest.fixture
def fake():
    """Make a fake robot: `fake(model, walls)`."""
    return FakeRobot


@pytest.fixture
def make_scan():
    """Make a scan from ranges over a full turn, beginning ahead, counter-clockwise."""

    def make(ranges, *, stamp_s: float = 10.0, range_min: float = 0.12, range_max: float = 3.5):
        values = np.asarray(ranges, dtype=np.float32)
        increment = math.tau / max(1, len(values))
        return Scan(stamp_s, 0.0, increment, range_min, range_max, values)

    return make
