"""Odometry: pose and velocity reckoned from the wheels alone."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bt_mission.core.robot.drives import DifferentialDrive
from bt_mission.core.robot.model import load_robot
from sim.sensors.odometry import Odometry, wrapped

WAFFLE = load_robot("waffle")
assert isinstance(WAFFLE.drive, DifferentialDrive)
RADIUS, SEPARATION = WAFFLE.drive.wheel_radius, WAFFLE.drive.wheel_separation


def started(left: float = 0.0, right: float = 0.0) -> Odometry:
    """Odometry that has seen its first reading at 1 s."""
    odometry = Odometry(WAFFLE)
    odometry.read(left, right, 1_000_000_000)
    return odometry


def test_it_starts_at_zero_wherever_the_wheels_stand():
    """The first reading is the reference."""
    odometry = started(12.0, -7.0)
    assert (odometry.x, odometry.y, odometry.yaw) == (0, 0, 0)
    assert (odometry.linear, odometry.angular) == (0, 0)


def test_both_wheels_alike_go_straight():
    """Ten radians of a wheel are 0.33 m; in 2 s, 0.165 m/s."""
    odometry = started()
    odometry.read(10.0, 10.0, 3_000_000_000)
    assert (odometry.x, odometry.y, odometry.yaw) == pytest.approx((0.33, 0, 0))
    assert (odometry.linear, odometry.angular) == pytest.approx((0.165, 0))


def test_wheels_against_each_other_turn_on_the_spot():
    """Half a turn to the left: the right wheel ahead by pi times the separation."""
    odometry = started()
    angle = math.pi * SEPARATION / 2 / RADIUS
    odometry.read(-angle, angle, 2_000_000_000)
    assert (odometry.x, odometry.y) == pytest.approx((0, 0))
    assert abs(odometry.yaw) == pytest.approx(math.pi)
    assert odometry.angular == pytest.approx(math.pi)


def test_an_arc_is_exact_however_few_readings_it_has():
    """A quarter circle of 1 m, read once, ends at (1, 1)."""
    odometry = started()
    quarter = math.pi / 2
    odometry.read(
        quarter * (1 - SEPARATION / 2) / RADIUS,
        quarter * (1 + SEPARATION / 2) / RADIUS,
        2_000_000_000,
    )
    assert (odometry.x, odometry.y, odometry.yaw) == pytest.approx((1, 1, quarter))


def test_a_reading_taken_twice_counts_once():
    """At the same instant nothing changes, the velocity neither."""
    odometry = started()
    odometry.read(1.0, 1.0, 2_000_000_000)
    before = (odometry.x, odometry.linear)
    odometry.read(1.0, 1.0, 2_000_000_000)
    assert (odometry.x, odometry.linear) == before


@given(st.floats(-100, 100))
def test_wrapped_angles_lie_within_half_a_turn(angle):
    """The direction stays the same."""
    assert -math.pi < wrapped(angle) <= math.pi + 1e-12
    assert math.cos(wrapped(angle)) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped(angle)) == pytest.approx(math.sin(angle), abs=1e-9)
