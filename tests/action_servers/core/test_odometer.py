"""Facts about adding up odometry."""

from __future__ import annotations

import math

import pytest

from action_servers.core.maneuver import Observation
from action_servers.core.progress import Odometer
from bt_mission.core.geometry import Pose2D


@pytest.fixture
def odometer():
    """An odometer with the limits of a Waffle."""
    return Odometer(max_linear=0.26, max_angular=1.82)


def at(stamp_s: float, x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> Observation:
    """Odometry at a time."""
    return Observation(stamp_s, odom=Pose2D(x, y, yaw), odom_stamp_s=stamp_s)


def test_starts_where_the_robot_is(odometer):
    """The first pose is no distance."""
    assert odometer.update(at(1.0, x=5.0, yaw=2.0)) is None
    assert (odometer.distance, odometer.yaw) == (0.0, 0.0)


def test_distance_is_the_length_of_the_path(odometer):
    """There and back again is twice the way."""
    for i, x in enumerate([0.0, 0.1, 0.2, 0.1, 0.0]):
        odometer.update(at(1.0 + 0.5 * i, x=x))
    assert odometer.distance == pytest.approx(0.4)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_yaw_is_not_wrapped(odometer, sign):
    """Two turns are 4 pi, though odometry jumps from pi to -pi on the way."""
    steps = 200
    for i in range(steps + 1):
        yaw = math.remainder(sign * i * 4.0 * math.pi / steps, math.tau)
        assert odometer.update(at(1.0 + 0.05 * i, yaw=yaw)) is None
    assert odometer.yaw == pytest.approx(sign * 4.0 * math.pi)


def test_the_same_message_counts_once(odometer):
    """It may be seen at several control steps."""
    odometer.update(at(1.0))
    odometer.update(at(1.5, x=0.1))
    odometer.update(at(1.5, x=0.1))
    assert odometer.distance == pytest.approx(0.1)


@pytest.mark.parametrize("elapsed_s", [0.05, -3.0])
def test_a_reset_of_odometry_is_told(odometer, elapsed_s):
    """Whether the stamps go on or go back; nothing is added."""
    odometer.update(at(10.0, x=2.0))
    reason = odometer.update(at(10.0 + elapsed_s))
    assert reason == f"odometry jumped by 2.00 m in {elapsed_s:.3f} s; was it reset?"
    assert odometer.distance == 0.0


def test_a_reset_of_the_heading_is_told(odometer):
    """A robot that turned on the spot has only its heading to lose."""
    odometer.update(at(1.0, yaw=2.0))
    assert odometer.update(at(1.05)) == ("odometry jumped by -115 deg in 0.050 s; was it reset?")


def test_a_long_gap_allows_a_long_way(odometer):
    """At the robot's speed, 0.2 m in 0.8 s is no jump."""
    odometer.update(at(1.0))
    assert odometer.update(at(1.8, x=0.2)) is None
    assert odometer.distance == pytest.approx(0.2)


def test_no_odometry_changes_nothing(odometer):
    """Freshness is somebody else's concern."""
    assert odometer.update(Observation(1.0)) is None
