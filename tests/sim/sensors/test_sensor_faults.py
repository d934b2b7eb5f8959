"""Faults of a robot's parts: as records, in readings against a run without them, on its topics."""

import math

import numpy as np
import pytest
from std_srvs.srv import Trigger

from bt_mission.robots.model import SensorsModel
from sim.faults import FaultError, RobotFaultState, WheelFaults
from sim.robot.robot import PARTS, SimulatedRobot
from sim.sensors.camera import CameraFaults, PictureDistortion
from sim.sensors.imu import Imu
from sim.sensors.lidar import LidarFaults, sector
from tests.support.simulated import alone, wait

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


# ---- records -----------------------------------------------------------------------------


@pytest.fixture
def wheels():
    """What the wheels were told."""
    return []


@pytest.fixture
def faults(wheels):
    """Those of a robot with which nothing is wrong."""
    return RobotFaultState(PARTS, wheels.append)


def test_a_part_that_is_not_there_cannot_break(wheels):
    """But all is mended as ever."""
    faults = RobotFaultState(PARTS, wheels.append, {"camera": "a cart has no camera"})
    with pytest.raises(FaultError, match=r"^a cart has no camera$"):
        faults.set("camera", dead=True)
    faults.clear()
    assert faults.present == {}


def test_what_is_not_named_stays_as_it_is(faults):
    """Noise is set, then death; each is taken away again. Then it is none, by identity."""
    assert faults.present == {}
    faults.set("lidar", noise=0.1)
    faults.set("lidar", dead=True)
    assert faults["lidar"] == LidarFaults(noise=0.1, dead=True)
    faults.set("lidar", dead=False)
    assert faults.present == {"lidar": LidarFaults(noise=0.1)}
    faults.set("lidar", noise=0.0)
    assert faults["lidar"] is PARTS["lidar"]


def test_a_part_is_mended_or_all(faults, wheels):
    """The wheels are told of it, too."""
    faults.set("lidar", noise=0.1)
    faults.set("camera", black=True)
    faults.set("wheels", left_blocked=True)
    faults.clear("lidar")
    assert faults.present == {
        "camera": CameraFaults(black=True),
        "wheels": WheelFaults(left_blocked=True),
    }
    faults.clear()
    assert faults.present == {}
    assert faults["camera"] is PARTS["camera"]
    assert wheels == [WheelFaults(left_blocked=True), WheelFaults()]
    with pytest.raises(FaultError, match="no part 'gripper' that can break"):
        faults.clear("gripper")


@pytest.mark.parametrize(
    ("part", "changes", "expected"),
    [
        ("lidr", {}, r"no part 'lidr' that can break \(known: .*lidar, .*mean 'lidar'\?"),
        (
            "lidar",
            {"nose": 1},
            r"no fault 'nose' of the part 'lidar' \(known: dead, .*'noise'",
        ),
        ("lidar", {"noise": -0.1}, "lidar: noise: expected 0 to 10 m, got -0.1"),
        ("lidar", {"noise": math.nan}, "lidar: noise: expected 0 to 10 m, got nan"),
        ("lidar", {"noise": True}, "lidar: noise: expected 0 to 10 m, got True"),
        ("lidar", {"dropout": 1.1}, "expected 0 to 1 of all rays, got 1.1"),
        ("lidar", {"dead": 1}, "lidar: dead: expected True or False, got 1"),
        ("lidar", {"sectors": (-20, 20)}, r"sectors: expected \(\(FROM, TO\), .*, got \(-20, 20\)"),
        ("lidar", {"sectors": ((0, math.inf),)}, r"degrees from -360 to 360, left positive"),
        ("odometry", {"drift": "fast"}, "odometry: drift: expected -10 to 10 m/s, got 'fast'"),
        ("wheels", {"left_grip": 2}, r"left_grip: expected 0 to 1 \(1: as it is\), got 2"),
    ],
)
def test_what_cannot_be_is_refused(faults, part, changes, expected):
    """With what can; nothing has changed."""
    with pytest.raises(FaultError, match=expected):
        faults.set(part, **changes)
    assert faults.present == {}


# ---- readings ----------------------------------------------------------------------------


def test_a_bias_is_on_every_distance_up_to_the_limits(pair):
    """30 cm too far, exactly; nothing stays nothing; beyond 3.5 m inf, below 0.12 m 0."""
    broken, sound = pair(**EXACT)
    broken.faults.set("lidar", bias=0.3)
    seen, true = broken.scan(0), sound.scan(0)
    both = np.isfinite(seen)
    assert seen[both] == pytest.approx(true[both] + 0.3, abs=1e-6)
    assert np.isinf(seen[np.isinf(true)]).all()
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
    for command, factor, reading in (((0.2, 0.0), ahead, "linear"), ((0.0, 1.0), turned, "yaw")):
        broken, sound = pair()
        broken.faults.set("odometry", **faults)
        for simulation in (broken, sound):
            drive(simulation, 2.0, *command)
        assert broken.pose == sound.pose
        expected = factor * getattr(sound.odometry, reading)
        assert getattr(broken.odometry, reading) == pytest.approx(expected, rel=1e-3)


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
        wait(broken, 0.05)
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
    for share in (-0.1, 1.1, math.nan):
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


# ---- topics ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("part", "silent", "goes_on"),
    [
        ("lidar", {"scan"}, {"odom", "imu", "joint_states", "tf"}),
        ("odometry", {"odom", "tf"}, {"scan", "imu", "joint_states", "ground_truth/odom"}),
        ("imu", {"imu"}, {"scan", "odom", "joint_states", "tf"}),
        ("joints", {"joint_states"}, {"scan", "odom", "imu", "tf"}),
        ("camera", {"camera/camera_info", "camera/image_raw"}, {"scan", "odom"}),
    ],
)
def test_a_dead_sensor_is_silent_and_comes_back(make_stage, make_world, part, silent, goes_on):
    """For a second; the others go on, and afterwards it goes on, too, with stamps of its time."""
    here = make_stage(make_world(walls=[WALL]), *silent, *goes_on)
    here.run(2 * S)
    here.received.clear()
    here.sim.robots[0].faults.set(part, dead=True)
    here.run(3 * S)
    assert not any(here.messages(topic) for topic in silent)
    assert all(len(here.messages(topic)) >= 10 for topic in goes_on)
    here.sim.robots[0].faults.clear(part)
    here.run(4 * S)
    for topic in silent - {"tf"}:
        assert here.messages(topic)[0].header.stamp.sec == 3


@pytest.mark.parametrize("model", ["LDS-01", "LDS-02"])
def test_a_frozen_lidar_repeats_its_scan_with_fresh_stamps(make_stage, make_world, waffle, model):
    """The same ranges and another stamp each time, while the robot turns."""
    robot = waffle.with_sensors(type(waffle.sensors).model_validate({"lidar": {"model": model}}))
    here = make_stage(make_world(walls=[WALL]), "scan", robot=robot)
    here.run(2 * S)
    here.sim.robots[0].faults.set("lidar", frozen=True)
    last = here.messages("scan")[-1].ranges.tobytes()
    here.received.clear()
    for tenth in range(20, 30):
        here.command(0.0, 1.0)
        here.run(tenth * S // 10)
    scans = here.messages("scan")
    assert len(scans) >= 9
    assert {scan.ranges.tobytes() for scan in scans} == {last}
    assert len({(scan.header.stamp.sec, scan.header.stamp.nanosec) for scan in scans}) == len(scans)


def test_the_reset_service_mends_all_and_takes_props_away(make_stage, make_world):
    """As at the start."""
    here = make_stage(make_world(walls=[WALL]), "scan", props=1)
    here.run(2 * S)
    simulation = here.sim.robots[0]
    simulation.faults.set("lidar", dead=True)
    simulation.physics.props.place("box", 1.0, 0.0, radius=0.1)
    client = here.ear.create_client(Trigger, "reset_simulation")
    client.call_async(Trigger.Request())
    here.clock.run_until_quiet()
    assert simulation.faults.present == {}
    assert not simulation.physics.props
    here.received.clear()
    here.run(3 * S)
    assert here.messages("scan")


@pytest.mark.parametrize(
    ("faults", "check"),
    [
        ({"black": True}, lambda seen, before: not any(seen.data)),
        ({"frozen": True}, lambda seen, before: seen.data == before.data),
        ({"noise": 0.2}, lambda seen, before: seen.data != before.data),
        ({}, lambda seen, before: seen.data != before.data),
    ],
)
def test_a_camera_shows_black_or_the_last_or_noise(make_stage, make_world, faults, check):
    """While the robot turns before a wall of several colours."""
    boxes = [{"x": 1.5, "y": y / 2, "size": [0.1, 0.2, 0.4], "colour": "red"} for y in range(-3, 4)]
    here = make_stage(make_world(boxes=boxes), "camera/image_raw")
    here.run(15 * S // 10)
    before = here.messages("camera/image_raw")[-1]
    here.received.clear()
    here.sim.robots[0].faults.set("camera", **faults)
    here.command(0.0, 1.0)
    here.run(17 * S // 10)
    assert check(here.messages("camera/image_raw")[-1], before)
