import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from action_servers.core.drive_limits import DriveLimits, Ramp, limits, speed_to_stop_in
from action_servers.core.maneuver import ZERO
from bt_mission.base.geometry import Twist2D

LIMITS = DriveLimits(linear=0.26, angular=1.0, acceleration=1.0, angular_acceleration=4.0)


def test_limits_are_the_robots_own(waffle):
    """Linear velocity and accelerations as they are; it turns at 60 % of what it can."""
    result = limits(waffle)
    assert result.linear == waffle.max_linear_velocity
    assert result.acceleration == waffle.max_linear_acceleration
    assert result.angular == pytest.approx(0.6 * waffle.max_angular_velocity)


@pytest.mark.parametrize(
    ("distance", "speed"), [(0.02, math.sqrt(2 * 0.4 * 0.02)), (5.0, 0.26), (-0.1, 0.0)]
)
def test_the_approach_speed_stops_within_the_distance(distance, speed):
    """At 40 % of the deceleration that the robot has."""
    assert LIMITS.approach(distance) == pytest.approx(speed)


@pytest.mark.parametrize(("angle", "rate"), [(-3.0, -1.0), (0.02, 0.08)])
def test_a_spin_has_the_sign_of_its_angle_and_fades_out(angle, rate):
    """Far away at full rate, close by in proportion to the angle."""
    assert LIMITS.spin(angle) == pytest.approx(rate)


def test_a_ramp_changes_a_twist_no_faster_than_the_robot_can():
    """1.0 m/s² over 0.05 s is 0.05 m/s, 4.0 rad/s² is 0.2 rad/s."""
    ramp = Ramp(LIMITS)
    assert ramp.toward(Twist2D(0.26, -1.0), 0.05) == Twist2D(0.05, -0.2)
    assert ramp.toward(Twist2D(0.08, -0.3), 0.05) == Twist2D(0.08, -0.3)
    assert ramp.stop() == ZERO
    assert ramp.twist == ZERO


@given(st.floats(1e-6, 100.0), st.floats(0.01, 10.0), st.floats(0.0, 1.0))
def test_delay_and_braking_use_up_exactly_the_distance(distance, deceleration, delay_s):
    """Distance = v * delay + v**2 / (2 * deceleration)."""
    speed = speed_to_stop_in(distance, deceleration=deceleration, delay_s=delay_s)
    used = speed * delay_s + speed**2 / (2.0 * deceleration)
    assert used == pytest.approx(distance, rel=1e-6)


@pytest.mark.parametrize(("distance", "speed"), [(0.0, 0.0), (-0.1, 0.0), (math.inf, math.inf)])
def test_no_distance_allows_no_speed_and_a_free_way_any(distance, speed):
    """Nor does a distance that is overrun already; the caller has a limit of its own."""
    assert speed_to_stop_in(distance, deceleration=1.0, delay_s=0.05) == speed
