"""Ranges against geometry: distances, directions, limits, noise."""

import math

import numpy as np
import pytest

from bt_mission.core.robot.model import RobotModel
from tests.support.simulated import alone

ARENA = [
    {"from": [2, -3], "to": [2, 3], "thickness": 0.2},
    {"from": [-3, 3], "to": [3, 3], "thickness": 0.2},
]
LIDAR_X = -0.064
"""Metres behind the axle at which the Waffle's lidar stands."""


@pytest.fixture(scope="module")
def exact(waffle):
    """A Waffle whose lidar has no noise."""
    fields = waffle.model_dump()
    fields["lidar"]["noise_std"] = 0.0
    return RobotModel.model_validate(fields)


@pytest.fixture
def look(make_world, exact):
    """The scan of that Waffle at the start, in a world of these fields."""

    def look(**fields: object) -> np.ndarray:
        return alone(make_world(**fields), exact, seed=0).scan(0)

    return look


def test_there_is_a_ray_for_every_degree(look):
    """360 single-precision ranges."""
    ranges = look()
    assert ranges.shape == (360,)
    assert ranges.dtype == np.float32


def test_ranges_are_measured_from_the_lidar_to_the_faces(look):
    """Ahead a wall 1.9 m from the axle, left one 2.9 m away, nothing behind and right."""
    ranges = look(walls=ARENA)
    assert ranges[0] == pytest.approx(1.9 - LIDAR_X, abs=2e-4)
    assert ranges[90] == pytest.approx(2.9, abs=2e-4)
    assert math.isinf(ranges[180])
    assert math.isinf(ranges[270])


def test_rays_run_counter_clockwise(look):
    """Ray i looks i degrees to the left; along a wall the range grows with 1/cos."""
    ranges = look(walls=ARENA)
    for degrees in (10, 30, 45):
        expected = (1.9 - LIDAR_X) / math.cos(math.radians(degrees))
        assert ranges[degrees] == pytest.approx(expected, abs=5e-4)
        assert ranges[360 - degrees] == pytest.approx(expected, abs=5e-4)


def test_the_scan_turns_with_the_robot(look):
    """Facing left, the wall that was ahead is on the right, nearer by none of the offset."""
    ranges = look(walls=ARENA, spawn={"yaw": 90})
    assert ranges[270] == pytest.approx(1.9, abs=2e-4)
    assert ranges[0] == pytest.approx(2.9 - LIDAR_X, abs=2e-4)


def test_a_cylinder_is_seen_at_its_rim(look):
    """A pillar of 0.2 m at 1 m behind."""
    ranges = look(cylinders=[{"x": -1, "y": 0, "radius": 0.2}])
    assert ranges[180] == pytest.approx(0.8 + LIDAR_X, abs=5e-4)


def test_what_is_too_far_reads_inf(look):
    """The LDS-01 sees 3.5 m."""
    far = look(walls=[{"from": [3.6, -1], "to": [3.6, 1], "thickness": 0.2}])
    near = look(walls=[{"from": [3.5, -1], "to": [3.5, 1], "thickness": 0.2}])
    assert math.isinf(far[0])
    assert near[0] == pytest.approx(3.464, abs=5e-4)


def test_what_is_too_near_reads_zero(simulate, make_world, waffle):
    """Nearer than 0.12 m the driver of the LDS-01 says 0.0; a Waffle's hull keeps things off."""
    fields = waffle.model_dump()
    fields["lidar"] |= {"noise_std": 0.0, "min_range": 0.5}
    robot = RobotModel.model_validate(fields)
    wall = {"from": [0.3, -1], "to": [0.3, 1], "thickness": 0.02}
    ranges = alone(make_world(walls=[wall]), robot, seed=0).scan(0)
    assert ranges[0] == 0.0
    assert ranges[50] == pytest.approx((0.29 - LIDAR_X) / math.cos(math.radians(50)), abs=5e-4)


def test_it_does_not_see_the_robot_that_carries_it_nor_the_floor(look):
    """On an empty floor every ray is free, zones or not."""
    zone = {"name": "A", "x": 0.5, "y": 0, "radius": 0.4}
    assert np.isinf(look(zones=[zone])).all()


def test_noise_has_the_published_deviation(simulate):
    """0.01 m about the truth, other at each measurement, the same at the same."""
    simulation = simulate(walls=ARENA)
    scans = np.array([simulation.scan(index) for index in range(200)])
    errors = scans[:, 0].astype(float) - (1.9 - LIDAR_X)
    assert errors.mean() == pytest.approx(0, abs=0.003)
    assert errors.std() == pytest.approx(0.01, rel=0.15)
    assert np.array_equal(simulation.scan(7), scans[7])
