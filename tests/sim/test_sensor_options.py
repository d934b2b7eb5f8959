"""Options of the simulated sensors: another lidar, noise or none, drift."""

import math

import numpy as np
import pytest

from bt_mission.core.robot.model import SensorsModel
from sim.robot.robot import SimulatedRobot
from sim.sensors.imu import Imu
from tests.support.simulated import alone

WALLS = [
    {"from": [5, -6], "to": [5, 6], "thickness": 0.2},
    {"from": [-6, 1], "to": [6, 1], "thickness": 0.2},
]
LIDAR_X = -0.064


@pytest.fixture
def equipped(waffle, make_world):
    """Makes a simulation of a Waffle with these options, between walls."""

    def equipped(seed: int = 1, walls: object = WALLS, **options: object) -> SimulatedRobot:
        robot = waffle.with_sensors(SensorsModel.model_validate(options))
        return alone(make_world(walls=walls), robot, seed=seed)

    return equipped


def test_an_lds_02_reaches_from_0_16_to_8_metres(equipped):
    """230 rays at 10 Hz; a wall 4.9 m away is seen, nothing behind is NaN."""
    simulation = equipped(lidar={"model": "LDS-02", "noise": False})
    ranges = simulation.scan(0)
    assert ranges.shape == (230,)
    assert ranges[0] == pytest.approx(4.9 - LIDAR_X, abs=1e-3)
    assert math.isnan(ranges[round(230 * 0.75)])


def test_an_lds_02_varies_its_number_of_rays(equipped):
    """By a few, about 230, and the same at the same measurement."""
    simulation = equipped(lidar={"model": "LDS-02"})
    counts = [len(simulation.scan(index)) for index in range(200)]
    assert np.mean(counts) == pytest.approx(230, abs=0.5)
    assert 0.5 < np.std(counts) < 3
    assert len(set(counts)) > 3
    assert np.array_equal(simulation.scan(7), simulation.scan(7), equal_nan=True)


def test_an_lds_02_has_gaps_where_there_is_something(equipped):
    """About one direction in a hundred, other ones each time."""
    simulation = equipped(lidar={"model": "LDS-02"})
    left = [simulation.scan(index)[30:90] for index in range(200)]
    assert np.isnan(left).mean() == pytest.approx(0.01, abs=0.003)


def test_noise_of_an_lds_02_grows_with_the_range(equipped):
    """1 % of 4.96 m ahead, 1 % of 0.9 m on the left."""
    simulation = equipped(lidar={"model": "LDS-02"})
    scans = [simulation.scan(index) for index in range(300)]
    ahead = np.array([scan[0] for scan in scans])
    left = np.array([scan[round(len(scan) / 4)] for scan in scans])
    assert np.nanstd(ahead) == pytest.approx(0.01 * 4.964, rel=0.15)
    assert np.nanstd(left) == pytest.approx(0.01 * 0.9, rel=0.15)


def test_its_messages_are_those_of_its_driver(make_stage, make_world, waffle):
    """Ranges said to be from 0 to 100 m, whatever it can, and angles that fit the rays."""
    robot = waffle.with_sensors(SensorsModel.model_validate({"lidar": {"model": "LDS-02"}}))
    here = make_stage(make_world(walls=WALLS), "scan", robot=robot)
    here.run(3_000_000_000)
    scans = here.messages("scan")
    assert len({len(scan.ranges) for scan in scans}) > 1
    for scan in scans:
        assert (scan.range_min, scan.range_max) == (0.0, 100.0)
        assert scan.angle_increment * len(scan.ranges) == pytest.approx(math.tau)
        assert scan.angle_max == pytest.approx(scan.angle_increment * (len(scan.ranges) - 1))


def test_without_noise_readings_are_exact(equipped):
    """Lidar and IMU, each by itself."""
    simulation = equipped(lidar={"noise": False}, imu={"noise": False})
    walls = [{"from": [2, -6], "to": [2, 6], "thickness": 0.2}]
    near = equipped(walls=walls, lidar={"noise": False})
    assert np.array_equal(near.scan(0), near.scan(1))
    assert near.scan(0)[0] == pytest.approx(1.9 - LIDAR_X, abs=2e-4)
    assert near.sensor(Imu).measure(0) != near.sensor(Imu).measure(1)
    assert simulation.sensor(Imu).measure(0) == simulation.sensor(Imu).measure(1)


def test_wheels_taken_for_larger_make_odometry_run_ahead(equipped, drive):
    """1 % too large, 1 % too far."""
    simulation = equipped(odometry={"wheel_radius_error": 0.01})
    drive(simulation, 5.0, linear=0.2)
    drive(simulation, 0.5)
    assert simulation.odometry.x == pytest.approx(1.01 * simulation.pose[0], rel=1e-3)


def test_wheels_taken_to_be_farther_apart_make_it_turn_less(equipped, drive):
    """10 % farther apart, 1.1 times less turned."""
    simulation = equipped(odometry={"wheel_separation_error": 0.1})
    drive(simulation, 2.0, angular=1.0)
    true = simulation.pose[2] * 0.288 / 0.287
    assert simulation.odometry.yaw == pytest.approx(true / 1.1, rel=0.01)


def test_slip_makes_odometry_and_joints_run_ahead(equipped, drive):
    """5 % in the mean; the seed decides how much each time; the truth is as without."""
    first, second = (equipped(seed=seed, odometry={"slip": 0.05}) for seed in (1, 2))
    for simulation in (first, second):
        drive(simulation, 5.0, linear=0.2)
    assert first.odometry.x == pytest.approx(1.05 * first.pose[0], rel=0.01)
    assert first.wheels[0][0] * 0.033 == pytest.approx(1.05 * first.pose[0], rel=0.02)
    assert first.pose == second.pose
    assert first.odometry.y != second.odometry.y
