"""Physics: commanded speeds are reached, commands run out, nothing creeps, all of it repeats."""

import hashlib
import math

import pytest

from bt_mission.robots.model import load_robot
from sim.robot.fit import SpawnError
from sim.sensors.imu import Imu
from sim.world.loader import load_world
from tests.support.simulated import alone, wait

S = 1_000_000_000
STEP = 5_000_000


@pytest.mark.parametrize("name", ["waffle", "burger"])
@pytest.mark.parametrize("speed", [0.2, "max"])
def test_straight_driving_goes_as_far_as_commanded(make_world, drive, name, speed):
    """Over 2 m the truth is within 5 mm of command, odometry within 1 mm of the truth."""
    robot = load_robot(name)
    linear = robot.max_linear_velocity if speed == "max" else speed
    simulation = alone(make_world(), robot, seed=1)
    seconds = round(2 / linear / 0.05) * 0.05
    drive(simulation, seconds, linear=linear)
    assert simulation.velocity == pytest.approx((linear, 0), abs=1e-3)
    drive(simulation, 1.0)
    x, y, yaw = simulation.pose
    assert x == pytest.approx(linear * seconds, abs=0.005)
    assert (y, yaw) == pytest.approx((0, 0), abs=1e-4)
    assert simulation.read_odometry().x == pytest.approx(x, abs=0.001)
    assert simulation.distance_travelled == pytest.approx(x, abs=0.001)


@pytest.mark.parametrize("rate", [0.5, 1.5, -1.5])
def test_turning_on_the_spot_turns_as_far_as_commanded(simulate, drive, rate):
    """360 degrees: the truth falls 0.35 % short, as its wheels stand 1 mm farther apart."""
    simulation = simulate()
    seconds = round(math.tau / abs(rate) / 0.05) * 0.05
    drive(simulation, seconds, angular=rate)
    assert simulation.velocity[1] == pytest.approx(rate * 0.287 / 0.288, rel=5e-3)
    drive(simulation, 1.0)
    x, y, yaw = simulation.pose
    commanded = rate * seconds
    short = math.remainder(commanded * 0.287 / 0.288 - yaw, math.tau)
    assert short == pytest.approx(0, abs=math.radians(1))
    assert math.remainder(simulation.read_odometry().yaw - commanded, math.tau) == (
        pytest.approx(0, abs=math.radians(1))
    )
    assert math.hypot(x, y) < 1e-3


def test_at_rest_it_does_not_creep(simulate):
    """In 60 s without a command it moves by less than a hundredth of a millimetre."""
    simulation = simulate()
    start = simulation.pose
    wait(simulation, 60.0)
    assert simulation.pose == pytest.approx(start, abs=1e-5)
    assert simulation.distance_travelled < 1e-5
    assert simulation.velocity == pytest.approx((0, 0), abs=1e-6)


@pytest.mark.parametrize("factor", [1, 10])
def test_it_stands_within_half_a_second_of_the_end_of_a_command(simulate, factor):
    """The ramp down begins at 0.2 s, exactly, or at ten times that; 0.2 s later it stands."""
    simulation = simulate()
    simulation.scale_command_timeout(factor)
    simulation.command(0.2, 0.0)
    wait(simulation, 0.2 * factor)
    assert simulation.commanded == (0.2, 0.0)
    wait(simulation, 0.005)
    assert simulation.commanded[0] == pytest.approx(0.195)
    wait(simulation, 0.195)
    assert simulation.commanded == (0.0, 0.0)
    wait(simulation, 0.1)
    assert simulation.velocity == pytest.approx((0, 0), abs=1e-3)


@pytest.mark.parametrize("sign", [1, -1])
def test_speed_follows_the_limits_of_the_model(simulate, sign):
    """1 m/s^2 and 6.97 rad/s^2, a little late for its servos, up to 0.26 m/s and 1.82 rad/s."""
    straight, simulation = simulate(), simulate()
    straight.command(sign * 5.0, 0.0)
    wait(straight, 0.1)
    assert sign * straight.velocity[0] == pytest.approx(0.1 - 0.012, abs=0.005)
    simulation.scale_command_timeout(10)
    simulation.command(sign * 5.0, sign * 9.0)
    wait(simulation, 0.1)
    assert simulation.commanded == pytest.approx((sign * 0.1, sign * 0.697))
    wait(simulation, 0.4)
    assert simulation.commanded == (sign * 0.26, sign * 1.82)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_velocity_that_is_not_finite_is_refused(simulate, bad):
    """The last command stays."""
    simulation = simulate()
    simulation.command(0.1, 0.0)
    with pytest.raises(ValueError, match="expected a finite velocity"):
        simulation.command(bad, 0.0)
    wait(simulation, 0.2)
    assert simulation.commanded == (0.1, 0.0)


def test_pose_at_the_start_is_the_spawn(simulate):
    """Metres and degrees of the world, odometry at zero."""
    simulation = simulate(spawn={"x": 1, "y": -2, "yaw": 90})
    assert simulation.pose == pytest.approx((1, -2, math.pi / 2), abs=1e-5)
    odometry = simulation.read_odometry()
    assert (odometry.x, odometry.y, odometry.yaw) == (0, 0, 0)
    assert simulation.physics.time_ns == 1 * S


def test_a_robot_that_does_not_fit_is_refused(make_world, waffle):
    """The message names robot, spawn and what is in the way."""
    pillar = {"name": "pillar", "x": 0.2, "y": 0, "radius": 0.15}
    with pytest.raises(SpawnError, match=r"a waffle does not fit .*\(0, 0, 0 deg\).*'pillar'"):
        alone(make_world(cylinders=[pillar]), waffle, seed=0)


@pytest.mark.parametrize("by", [-STEP, 1, STEP + 1])
def test_time_moves_ahead_in_whole_steps(simulate, by):
    """The message gives both times and the step."""
    simulation = simulate()
    with pytest.raises(ValueError, match=r"from 1000000000 ns to \d+ ns: .* a multiple of 5000000"):
        simulation.physics.advance_to(simulation.physics.time_ns + by)


def test_one_long_advance_is_many_short_ones(simulate):
    """How time is cut into calls changes nothing."""
    first, many = simulate(), simulate()
    for simulation in (first, many):
        simulation.command(0.2, 0.5)
    first.physics.advance_to(2 * S)
    while many.physics.time_ns < 2 * S:
        many.physics.advance_to(many.physics.time_ns + STEP)
    assert first.pose == many.pose
    assert first.distance_travelled == many.distance_travelled


@pytest.mark.parametrize("name", ["waffle", "burger"])
def test_pushing_on_against_a_wall_it_stands_still(make_world, drive, name):
    """Its motors stall before its wheels slip: in 10 s not 1 mm of way, and 1 cm of odometry."""
    wall = {"from": [0.5, -1], "to": [0.5, 1], "thickness": 0.01}
    simulation = alone(make_world(walls=[wall]), load_robot(name), seed=0)
    drive(simulation, 4.0, linear=0.2)
    before, odometry_before = simulation.distance_travelled, simulation.read_odometry().x
    drive(simulation, 10.0, linear=0.2)
    assert simulation.distance_travelled - before < 0.001
    assert simulation.read_odometry().x - odometry_before < 0.01


def readings(seed: int) -> tuple[str, list[tuple[float, float, float]]]:
    """A digest of all that a drive of 4 s through stage 4 shows, to the last bit; and the poses."""
    simulation = alone(load_world("dqn_stage4"), load_robot("waffle"), seed=seed)
    seen, poses = hashlib.sha256(), []
    for index in range(40):
        simulation.command(0.2, 0.8 if index % 20 < 10 else -0.8)
        wait(simulation, 0.1)
        odometry, imu = simulation.read_odometry(), simulation.sensor(Imu).measure(index)
        seen.update(simulation.scan(index).tobytes())
        seen.update(repr((simulation.pose, odometry, imu)).encode())
        poses.append(simulation.pose)
    return seen.hexdigest(), poses


def test_the_same_seed_gives_the_same_run_and_another_seed_other_noise():
    """Bit for bit: poses, odometry, scans and inertial readings. The physics has no seed."""
    first, again, other = readings(1), readings(1), readings(2)
    assert first == again
    assert first[0] != other[0]
    assert first[1] == other[1]
