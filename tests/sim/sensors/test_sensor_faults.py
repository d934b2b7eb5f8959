"""Faults of sensors: each against the same run without it, in exact or bounded figures."""

import math

import numpy as np
import pytest

from bt_mission.core.robot.model import SensorsModel
from sim.faults import FaultError
from sim.robot.robot import SimulatedRobot
from sim.sensors.camera import CameraFaults, PictureDistortion
from sim.sensors.imu import Imu
from sim.sensors.lidar import sector
from tests.support.simulated import alone

WALL = {"name": "wall", "from": [2, -6], "to": [2, 6], "thickness": 0.2}
LEFT = {"name": "left", "from": [-6, 1], "to": [6, 1], "thickness": 0.2}
AHEAD = 1.9 + 0.064
"""From the lidar to the wall, m."""

S = 1_000_000_000


@pytest.fixture
def pair(waffle, make_world):
    """Makes two simulations that are the same, with these sensors."""

    def pair(seed: int = 1, **sensors: object) -> tuple[SimulatedRobot, SimulatedRobot]:
        robot = waffle.with_sensors(SensorsModel.model_validate(sensors))
        world = make_world(walls=[WALL, LEFT])
        broken, sound = (alone(world, robot, seed=seed) for _ in range(2))
        return broken, sound

    return pair


EXACT = {"lidar": {"noise": False}}


def test_a_bias_is_on_every_distance(pair):
    """30 cm too far, exactly; where there is nothing, there still is none."""
    broken, sound = pair(**EXACT)
    broken.faults.set("lidar", bias=0.3)
    seen, true = broken.scan(0), sound.scan(0)
    both = np.isfinite(seen)
    assert seen[both] == pytest.approx(true[both] + 0.3, abs=1e-6)
    assert np.isinf(seen[np.isinf(true)]).all()


def test_a_bias_takes_the_lidar_to_its_limits(pair):
    """Beyond 3.5 m it reads inf, below 0.12 m 0."""
    broken, sound = pair(**EXACT)
    true = sound.scan(0)
    broken.faults.set("lidar", bias=1.0)
    assert np.isinf(broken.scan(0)[true > 2.5]).all()
    broken.faults.set("lidar", bias=-1.0)
    assert not broken.scan(0)[true < 1.12].any()


def test_noise_comes_on_top_of_its_own(pair):
    """5 cm and its own 1 cm: 5.1 cm, about a mean that is right."""
    broken, _ = pair()
    broken.faults.set("lidar", noise=0.05)
    ahead = np.array([broken.scan(index)[0] for index in range(400)])
    assert ahead.std() == pytest.approx(math.hypot(0.05, 0.01), rel=0.1)
    assert ahead.mean() == pytest.approx(AHEAD, abs=0.01)


@pytest.mark.parametrize(
    ("start", "end", "lost"),
    [
        (-20, 20, {*range(21), *range(340, 360)}),
        (170, -170, set(range(170, 191))),
        (90, 92, {90, 91, 92}),
        (45, 45, {45}),
        (-180, 180, set(range(360))),
        (20, -20, set(range(20, 341))),
        (350, 10, {*range(11), *range(350, 360)}),
    ],
)
def test_a_sector_goes_counter_clockwise_from_one_bearing_to_the_other(start, end, lost):
    """Both ends belong to it; it may go round behind."""
    assert set(np.flatnonzero(sector(np.arange(360.0), start, end)).tolist()) == lost


@pytest.mark.parametrize(("model", "nothing"), [("LDS-01", np.inf), ("LDS-02", np.nan)])
def test_a_lost_sector_reads_as_nothing(pair, model, nothing):
    """40 degrees ahead and what lies behind; the rest is as it was."""
    broken, sound = pair(lidar={"model": model, "noise": False})
    broken.faults.set("lidar", sectors=((-20, 20), (170, -170)))
    seen, true = broken.scan(0), sound.scan(0)
    bearings = np.arange(len(seen)) * 360 / len(seen)
    lost = sector(bearings, -20, 20) | sector(bearings, 170, -170)
    assert np.array_equal(seen[lost], np.full(lost.sum(), nothing), equal_nan=True)
    assert np.array_equal(seen[~lost], true[~lost], equal_nan=True)


def test_dropout_loses_a_share_of_the_rays(pair):
    """A third of those that saw something, other ones each time; 1 is all of them."""
    broken, sound = pair(**EXACT)
    hits = np.isfinite(sound.scan(0))
    broken.faults.set("lidar", dropout=1 / 3)
    scans = [broken.scan(index)[hits] for index in range(100)]
    assert np.mean([np.isinf(scan) for scan in scans]) == pytest.approx(1 / 3, abs=0.02)
    assert not np.array_equal(scans[0], scans[1])
    broken.faults.set("lidar", dropout=1)
    assert np.isinf(broken.scan(0)).all()


@pytest.mark.parametrize("fault", [{"noise": 0.05}, {"dropout": 0.2}])
@pytest.mark.parametrize("model", ["LDS-01", "LDS-02"])
def test_what_is_random_depends_on_seed_and_measurement_alone(pair, fault, model):
    """The same measurement of the same seed is the same, whatever was measured or set before."""
    first, other = pair(lidar={"model": model})
    for simulation in (first, other):
        simulation.faults.set("lidar", **fault)
    for index in range(70):
        other.scan(index)
    other.faults.clear()
    other.faults.set("lidar", **fault)
    assert np.array_equal(first.scan(7), other.scan(7), equal_nan=True)
    third, _ = pair(seed=2, lidar={"model": model})
    third.faults.set("lidar", **fault)
    assert not np.array_equal(first.scan(7), third.scan(7), equal_nan=True)


@pytest.mark.parametrize("model", ["LDS-01", "LDS-02"])
def test_a_frozen_lidar_repeats_its_last_scan(pair, drive, model):
    """While the robot drives on; then it sees again, as if nothing had been."""
    broken, sound = pair(lidar={"model": model})
    last = broken.scan(0).copy()
    broken.faults.set("lidar", frozen=True)
    for simulation in (broken, sound):
        drive(simulation, 1.0, 0.2)
    assert np.array_equal(broken.scan(1), last, equal_nan=True)
    broken.faults.clear("lidar")
    assert np.array_equal(broken.scan(3), sound.scan(3), equal_nan=True)


def test_frozen_before_its_first_scan_it_repeats_that(pair, drive):
    """There is nothing else to repeat."""
    broken, sound = pair()
    broken.faults.set("lidar", frozen=True)
    first = broken.scan(0)
    assert np.array_equal(first, sound.scan(0))
    drive(broken, 1.0, 0.2)
    assert np.array_equal(broken.scan(1), first)


def test_mended_it_is_as_if_nothing_had_been(pair, drive):
    """Poses and readings, bit for bit, after faults of every sensor."""
    broken, sound = pair()
    broken.faults.set("lidar", noise=0.1, bias=0.2, dropout=0.5, sectors=((0, 90),))
    broken.faults.set("imu", dead=True)
    for simulation in (broken, sound):
        drive(simulation, 1.0, 0.2, 0.5)
        simulation.scan(0)
    broken.faults.clear()
    assert broken.pose == sound.pose
    assert broken.odometry == sound.odometry
    assert np.array_equal(broken.scan(1), sound.scan(1))
    assert broken.sensor(Imu).measure(1) == sound.sensor(Imu).measure(1)


def test_a_reset_mends_all(simulate, drive):
    """What follows is what follows the start, bit for bit."""
    broken, sound = simulate(), simulate()
    broken.faults.set("lidar", noise=0.1, frozen=True)
    broken.faults.set("odometry", drift=0.1)
    broken.faults.set("wheels", left_grip=0.1, right_blocked=True)
    broken.push((5.0, 5.0), 100.0)
    broken.charge_battery(0.2)
    broken.scan(0)
    drive(broken, 1.0, 0.2)
    broken.physics.reset()
    assert broken.faults.present == {}
    for simulation in (broken, sound):
        drive(simulation, 2.0, 0.2, 0.5)
    assert broken.pose == sound.pose
    assert (broken.odometry.x, broken.odometry.yaw) == (sound.odometry.x, sound.odometry.yaw)
    assert np.array_equal(broken.scan(0), sound.scan(0))
    assert broken.battery.charge == sound.battery.charge


@pytest.mark.parametrize(
    ("faults", "ahead", "turned"),
    [
        ({"left_radius_error": 0.1, "right_radius_error": 0.1}, 1.1, 1.1),
        ({"left_radius_error": 0.1, "right_radius_error": -0.1}, 1.0, 1.0),
        ({"separation_error": 0.25}, 1.0, 0.8),
    ],
)
def test_odometry_with_wrong_figures_is_off_by_a_factor(pair, drive, faults, ahead, turned):
    """Of the way ahead, and of a turn on the spot; the truth is as without."""
    for command, factor in (((0.2, 0.0), ahead), ((0.0, 1.0), turned)):
        broken, sound = pair()
        broken.faults.set("odometry", **faults)
        for simulation in (broken, sound):
            drive(simulation, 2.0, *command)
        assert broken.pose == sound.pose
        if command[1]:
            assert broken.odometry.yaw == pytest.approx(factor * sound.odometry.yaw, rel=1e-3)
        else:
            result = broken.odometry.linear
            assert result == pytest.approx(factor * sound.odometry.linear, rel=1e-3)


def test_a_wheel_taken_for_larger_makes_a_straight_way_an_arc(pair, drive):
    """The right one by 1 %: 0.2 m/s ahead is 2 mm/s across 0.287 m, a turn to the left."""
    broken, _ = pair()
    broken.faults.set("odometry", right_radius_error=0.01)
    drive(broken, 2.0, 0.2)
    assert broken.odometry.angular == pytest.approx(0.002 / 0.287, rel=0.01)


def test_odometry_that_drifts_moves_while_the_robot_stands(pair):
    """1 cm/s ahead and 9 deg/s to the left, for 10 s: a quarter of a circle, of 0.1 m."""
    broken, _ = pair()
    broken.read_odometry()
    broken.faults.set("odometry", drift=0.01, turn_drift=9)
    for _ in range(200):
        broken.physics.advance_to(broken.physics.time_ns + 50_000_000)
        broken.read_odometry()
    radius = 0.01 / math.radians(9)
    assert broken.odometry.yaw == pytest.approx(math.pi / 2, abs=1e-3)
    assert (broken.odometry.x, broken.odometry.y) == pytest.approx((radius, radius), abs=1e-4)
    assert broken.pose == pytest.approx((0, 0, 0), abs=1e-4)


def test_a_battery_is_emptied_or_filled(pair, drive):
    """Nearly empty it lasts for a moment; then the motors have no power until it is charged."""
    broken, _ = pair()
    broken.charge_battery(1e-6)
    drive(broken, 1.0, 0.2)
    assert broken.battery.is_empty
    assert not broken.motors_on
    assert not broken.power_motors(on=True)
    broken.charge_battery(0.5)
    assert broken.power_motors(on=True)
    assert broken.battery.percentage == 50


@pytest.mark.parametrize("share", [-0.1, 1.1, math.nan])
def test_a_charge_that_cannot_be_is_refused(pair, share):
    """0 to 1."""
    broken, _ = pair()
    with pytest.raises(FaultError, match=f"expected a charge from 0 to 1, got {share:g}"):
        broken.charge_battery(share)


def test_noise_of_a_picture_is_a_share_of_full_scale():
    """10 % of 255 about what was there; of the same picture the same, of the next one another."""
    distortion = PictureDistortion(1, "")
    pictures = [np.full((120, 160, 3), 128, dtype=np.uint8) for _ in range(3)]
    for index, picture in zip((4, 4, 5), pictures, strict=True):
        distortion.apply(CameraFaults(noise=0.1), picture, index)
    assert pictures[0].std() == pytest.approx(25.5, rel=0.02)
    assert pictures[0].mean() == pytest.approx(128, abs=0.5)
    assert np.array_equal(pictures[0], pictures[1])
    assert not np.array_equal(pictures[0], pictures[2])


def test_a_black_picture_is_black():
    """With noise on top, where there is some."""
    picture = np.full((120, 160, 3), 128, dtype=np.uint8)
    PictureDistortion(1, "").apply(CameraFaults(black=True), picture, 0)
    assert not picture.any()
    PictureDistortion(1, "").apply(CameraFaults(black=True, noise=0.1), picture, 0)
    assert picture.any()
