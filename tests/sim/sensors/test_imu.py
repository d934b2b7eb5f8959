"""The inertial sensor: gravity, turning, speeding up."""

import math

import numpy as np
import pytest

from sim.sensors.imu import Imu


def test_at_rest_it_feels_gravity_alone(simulate):
    """(0, 0, 9.81) m/s^2 and no turning, give or take the noise."""
    simulation = simulate()
    readings = [simulation.sensor(Imu).measure(index) for index in range(500)]
    acceleration = np.array([reading.linear_acceleration for reading in readings])
    turning = np.array([reading.angular_velocity for reading in readings])
    assert acceleration.mean(axis=0) == pytest.approx((0, 0, 9.81), abs=0.003)
    assert acceleration.std(axis=0) == pytest.approx((0.017,) * 3, rel=0.15)
    assert turning.mean(axis=0) == pytest.approx((0, 0, 0), abs=5e-5)
    assert turning.std(axis=0) == pytest.approx((2e-4,) * 3, rel=0.15)


def test_it_feels_turning_to_the_left_as_positive(simulate, drive):
    """About z, as fast as the base truly turns."""
    simulation = simulate()
    drive(simulation, 1.0, angular=1.0)
    reading = simulation.sensor(Imu).measure(0)
    assert reading.angular_velocity[2] == pytest.approx(simulation.velocity[1], abs=1e-3)
    assert reading.angular_velocity[2] == pytest.approx(1.0, abs=0.01)


def test_it_feels_speeding_up(simulate):
    """Ahead, about the 1 m/s^2 of the ramp."""
    simulation = simulate()
    simulation.command(0.26, 0.0)
    simulation.physics.advance_to(simulation.physics.time_ns + 150_000_000)
    assert simulation.sensor(Imu).measure(0).linear_acceleration[0] == pytest.approx(1.0, abs=0.15)


def test_attitude_is_counted_from_the_start(simulate, drive):
    """An IMU starts at zero, whatever the heading on the map."""
    simulation = simulate(spawn={"yaw": 120})
    assert simulation.sensor(Imu).measure(0).orientation == pytest.approx((1, 0, 0, 0), abs=1e-4)
    drive(simulation, 1.0, angular=1.0)
    w, x, y, z = simulation.sensor(Imu).measure(0).orientation
    turned = simulation.pose[2] - math.radians(120)
    assert 2 * math.atan2(z, w) == pytest.approx(turned, abs=1e-4)
    assert (x, y) == pytest.approx((0, 0), abs=1e-3)
