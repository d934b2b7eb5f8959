"""Ranges and inertial readings against geometry and motion: directions, limits, noise."""

import math

import numpy as np
import pytest

from bt_mission.robots.model import RobotModel, SensorsModel
from sim.sensors.imu import Imu
from sim.sensors.sensor import Noise
from tests.support.simulated import alone, wait

ARENA = [
    {"from": [2, -3], "to": [2, 3], "thickness": 0.2},
    {"from": [-3, 3], "to": [3, 3], "thickness": 0.2},
]
LIDAR_X = -0.064
"""Metres behind the axle at which the Waffle's lidar stands."""


@pytest.fixture
def look(make_world, waffle):
    """The scan of a Waffle whose lidar has no noise, at the start, in a world of these fields."""
    exact = waffle.with_sensors(SensorsModel.model_validate({"lidar": {"noise": False}}))

    def look(robot: RobotModel = exact, **fields: object) -> np.ndarray:
        return alone(make_world(**fields), robot, seed=0).scan(0)

    return look


def slanting(distance: float, degrees: float) -> float:
    """The range of a ray to a wall so far ahead of the axle, m."""
    return (distance - LIDAR_X) / math.cos(math.radians(degrees))


@pytest.mark.parametrize(
    ("fields", "ranges"),
    [
        ({"walls": ARENA}, {0: 1.9 - LIDAR_X, 90: 2.9, 180: math.inf, 270: math.inf}),
        (
            {"walls": ARENA},
            {side * d % 360: slanting(1.9, d) for d in (10, 30, 45) for side in (1, -1)},
        ),
        ({"walls": ARENA, "spawn": {"yaw": 90}}, {270: 1.9, 0: 2.9 - LIDAR_X}),
        ({"cylinders": [{"x": -1, "y": 0, "radius": 0.2}]}, {180: 0.8 + LIDAR_X}),
        ({"walls": [{"from": [3.5, -1], "to": [3.5, 1], "thickness": 0.2}]}, {0: 3.464}),
        ({"walls": [{"from": [3.6, -1], "to": [3.6, 1], "thickness": 0.2}]}, {0: math.inf}),
        (
            {"zones": [{"name": "A", "x": 0.5, "y": 0, "radius": 0.4}]},
            dict.fromkeys(range(360), math.inf),
        ),
    ],
    ids=[
        "from the lidar to the faces",
        "counter-clockwise along a wall",
        "turned with the robot",
        "a cylinder at its rim",
        "3.5 m away",
        "too far",
        "neither floor nor robot",
    ],
)
def test_ranges_are_those_of_the_geometry(look, fields, ranges):
    """360 single-precision ranges: ray i looks i degrees to the left."""
    scan = look(**fields)
    assert (scan.shape, scan.dtype) == ((360,), np.float32)
    assert {ray: scan[ray] for ray in ranges} == pytest.approx(ranges, abs=5e-4)


def test_what_is_too_near_reads_zero(look, waffle):
    """Nearer than 0.12 m the driver of the LDS-01 says 0.0; a Waffle's hull keeps things off."""
    fields = waffle.model_dump()
    fields["lidar"] |= {"noise_std": 0.0, "min_range": 0.5}
    wall = {"from": [0.3, -1], "to": [0.3, 1], "thickness": 0.02}
    ranges = look(RobotModel.model_validate(fields), walls=[wall])
    assert ranges[0] == 0.0
    assert ranges[50] == pytest.approx(slanting(0.29, 50), abs=5e-4)


def test_noise_has_the_published_deviation(simulate):
    """0.01 m about the truth, other at each measurement, the same at the same."""
    simulation = simulate(walls=ARENA)
    scans = np.array([simulation.scan(index) for index in range(200)])
    errors = scans[:, 0].astype(float) - (1.9 - LIDAR_X)
    assert errors.mean() == pytest.approx(0, abs=0.003)
    assert errors.std() == pytest.approx(0.01, rel=0.15)
    assert np.array_equal(simulation.scan(7), scans[7])


# ---- an LDS-02 ---------------------------------------------------------------------------


def test_an_lds_02_reaches_from_0_16_to_8_metres(equipped):
    """230 rays at 10 Hz; a wall 4.9 m away is seen, nothing behind is NaN."""
    ranges = equipped(lidar={"model": "LDS-02", "noise": False}).scan(0)
    assert ranges.shape == (230,)
    assert ranges[0] == pytest.approx(4.9 - LIDAR_X, abs=1e-3)
    assert math.isnan(ranges[round(230 * 0.75)])


def test_an_lds_02_varies_its_rays_has_gaps_and_noise_that_grows_with_the_range(equipped):
    """A few rays about 230; 1 % of directions; 1 % of 4.96 m ahead and of 0.9 m on the left."""
    simulation = equipped(lidar={"model": "LDS-02"})
    scans = [simulation.scan(index) for index in range(300)]
    counts = [len(scan) for scan in scans]
    assert np.mean(counts) == pytest.approx(230, abs=0.5)
    assert 0.5 < np.std(counts) < 3
    assert len(set(counts)) > 3
    assert np.array_equal(simulation.scan(7), scans[7], equal_nan=True)
    assert np.isnan([scan[30:90] for scan in scans]).mean() == pytest.approx(0.01, abs=0.003)
    ahead = np.array([scan[0] for scan in scans])
    left = np.array([scan[round(len(scan) / 4)] for scan in scans])
    assert np.nanstd(ahead) == pytest.approx(0.01 * 4.964, rel=0.15)
    assert np.nanstd(left) == pytest.approx(0.01 * 0.9, rel=0.15)


def test_messages_of_an_lds_02_are_those_of_its_driver(make_stage, make_world, waffle):
    """Ranges said to be from 0 to 100 m, whatever it can, and angles that fit the rays."""
    robot = waffle.with_sensors(SensorsModel.model_validate({"lidar": {"model": "LDS-02"}}))
    here = make_stage(make_world(walls=ARENA), "scan", robot=robot)
    here.run(3_000_000_000)
    scans = here.messages("scan")
    assert len({len(scan.ranges) for scan in scans}) > 1
    for scan in scans:
        assert (scan.range_min, scan.range_max) == (0.0, 100.0)
        assert scan.angle_increment * len(scan.ranges) == pytest.approx(math.tau)
        assert scan.angle_max == pytest.approx(scan.angle_increment * (len(scan.ranges) - 1))


def test_without_noise_readings_are_exact(equipped):
    """Lidar and IMU, each by itself."""
    near = equipped(walls=ARENA, lidar={"noise": False})
    assert np.array_equal(near.scan(0), near.scan(1))
    assert near.sensor(Imu).measure(0) != near.sensor(Imu).measure(1)
    other = equipped(walls=ARENA, imu={"noise": False})
    assert not np.array_equal(other.scan(0), other.scan(1))
    assert other.sensor(Imu).measure(0) == other.sensor(Imu).measure(1)


# ---- the inertial sensor -----------------------------------------------------------------


def test_at_rest_it_feels_gravity_alone(simulate):
    """(0, 0, 9.81) m/s^2 and no turning, give or take the noise."""
    imu = simulate().sensor(Imu)
    readings = [imu.measure(index) for index in range(500)]
    acceleration = np.array([reading.linear_acceleration for reading in readings])
    turning = np.array([reading.angular_velocity for reading in readings])
    assert acceleration.mean(axis=0) == pytest.approx((0, 0, 9.81), abs=0.003)
    assert acceleration.std(axis=0) == pytest.approx((0.017,) * 3, rel=0.15)
    assert turning.mean(axis=0) == pytest.approx((0, 0, 0), abs=5e-5)
    assert turning.std(axis=0) == pytest.approx((2e-4,) * 3, rel=0.15)


def test_it_feels_speeding_up(simulate):
    """Ahead, about the 1 m/s^2 of the ramp."""
    simulation = simulate()
    simulation.command(0.26, 0.0)
    wait(simulation, 0.15)
    assert simulation.sensor(Imu).measure(0).linear_acceleration[0] == pytest.approx(1.0, abs=0.15)


def test_it_feels_turning_and_counts_its_attitude_from_the_start(simulate, drive):
    """To the left is positive; it starts at zero, whatever the heading on the map."""
    simulation = simulate(spawn={"yaw": 120})
    assert simulation.sensor(Imu).measure(0).orientation == pytest.approx((1, 0, 0, 0), abs=1e-4)
    drive(simulation, 1.0, angular=1.0)
    reading = simulation.sensor(Imu).measure(0)
    assert reading.angular_velocity[2] == pytest.approx(simulation.velocity[1], abs=1e-3)
    assert reading.angular_velocity[2] == pytest.approx(1.0, abs=0.01)
    w, x, y, z = reading.orientation
    turned = simulation.pose[2] - math.radians(120)
    assert 2 * math.atan2(z, w) == pytest.approx(turned, abs=1e-4)
    assert (x, y) == pytest.approx((0, 0), abs=1e-3)


# ---- noise -------------------------------------------------------------------------------


@pytest.mark.parametrize("index", [0, 63, 64, 1000])
def test_noise_is_the_same_whatever_was_measured_before(index):
    """For the same seed, sensor and index."""
    source = Noise(3, "imu", 6)
    for earlier in (0, 5, 70, 2):
        source.at(earlier)
    assert np.array_equal(source.at(index), Noise(3, "imu", 6).at(index))


def test_seed_sensor_and_index_each_change_the_noise():
    """None of them share a value. Any whole number is a seed."""
    values = [
        Noise(seed, sensor, 4).at(index)
        for seed in (1, 2, -1, 2**80)
        for sensor in ("lidar", "imu")
        for index in (0, 1)
    ]
    assert len({tuple(row) for row in values}) == 16


def test_noise_is_normal_with_standard_deviation_one():
    """Mean 0 and deviation 1 over 100,000 values."""
    source = Noise(0, "lidar", 1000)
    values = np.concatenate([source.at(index) for index in range(100)])
    assert values.mean() == pytest.approx(0, abs=0.01)
    assert values.std() == pytest.approx(1, abs=0.01)
