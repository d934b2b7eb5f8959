"""Facts about bases that are not differential: commands, motion, wheels and odometry."""

from __future__ import annotations

import math

import pytest

from bt_mission.robots.model import load_robot
from sim.physics.spawn import RobotSpawn
from sim.simulation import Simulation
from sim.world.loader import load_world

PLANAR = ("rosbot", "f1tenth", "husky")
COMMANDS = ((0.2, 0.0, 0.0), (0.2, 0.2, 0.0), (-0.2, 0.2, 0.0), (0.0, 0.5, 0.0), (0.1, 0.2, 0.1))


def driven(name: str, command: tuple[float, float, float], seconds: float = 3.0, **faults):
    """Return a robot that was commanded (m/s, rad/s, m/s to the left) for a time."""
    simulation = Simulation(load_world("empty_arena"), [RobotSpawn(load_robot(name))], seed=1)
    robot = simulation.robots[0]
    for part, values in faults.items():
        robot.faults.set(part, **values)
    linear, angular, lateral = command
    for _ in range(round(seconds * 20)):
        robot.command(linear, angular, 0, lateral)
        simulation.advance_to(robot.physics.time_ns + 50_000_000)
        robot.read_odometry()
    return robot


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("name", PLANAR)
def test_odometry_is_within_millimetres_of_the_truth(name, command):
    """Where no wheel slips: 3 mm and 0.3 degrees after three seconds."""
    robot = driven(name, command)
    odometry, (x, y, yaw) = robot.odometry, robot.pose
    assert math.hypot(odometry.x - x, odometry.y - y) < 0.003
    assert odometry.yaw == pytest.approx(yaw, abs=0.005)


def test_a_base_that_slides_moves_sideways_and_others_do_not():
    """The same command to the left; a car and a skid-steered base ignore it."""
    assert driven("rosbot", (0.0, 0.0, 0.2)).pose[:2] == pytest.approx((0.0, 0.58), abs=0.01)
    for name in ("f1tenth", "husky"):
        assert driven(name, (0.0, 0.0, 0.2)).pose == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)


def test_a_car_does_not_turn_on_the_spot_nor_too_sharply():
    """Its turn follows from its way and its steering: at most tan(0.4189) / 0.3302 per metre."""
    assert driven("f1tenth", (0.0, 0.5, 0.0)).pose == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)
    robot = driven("f1tenth", (0.1, 0.6, 0.0))
    way = robot.distance_travelled
    assert robot.pose[2] / way == pytest.approx(robot.robot.drive.max_curvature, rel=0.02)
    *_, left, right = robot.wheels[0]
    assert left > robot.robot.drive.max_steering_angle > right  # the inner wheel turns further
    assert robot.joints[-1] == "front_right_steering_joint"


def test_the_wheels_of_a_mecanum_base_turn_as_its_rollers_demand():
    """Sideways, the wheels of a diagonal turn alike, and against those of the other."""
    speeds = driven("rosbot", (0.0, 0.0, 0.2)).wheels[1]
    expected = 0.2 / 0.047
    signs = (-1, 1, 1, -1)
    assert speeds == pytest.approx([sign * expected for sign in signs], rel=0.02)


@pytest.mark.parametrize("name", PLANAR)
def test_without_grip_the_wheels_turn_and_the_base_hardly_moves(name):
    """Odometry then believes in a way that was not made."""
    robot = driven(name, (0.3, 0.0, 0.0), wheels={"left_grip": 0.005, "right_grip": 0.005})
    assert robot.odometry.x > 0.8
    assert robot.pose[0] < 0.35


def test_a_blocked_side_turns_a_skid_steered_base_and_stops_a_car():
    """The other side drives on."""
    turned = driven("husky", (0.2, 0.0, 0.0), wheels={"left_blocked": True})
    assert turned.pose[2] > 0.2
    stopped = driven("f1tenth", (0.2, 0.0, 0.0), wheels={"left_blocked": True})
    assert stopped.distance_travelled < 0.01


@pytest.mark.parametrize("name", PLANAR)
def test_without_power_the_base_comes_to_rest_and_with_it_drives_on(name):
    """Gears brake it; commands have no effect."""
    robot = driven(name, (0.3, 0.0, 0.0), 1.0)
    robot.power_motors(on=False)
    for _ in range(40):
        robot.command(0.3, 0.0)
        robot.physics.advance_to(robot.physics.time_ns + 50_000_000)
    assert robot.velocity == pytest.approx((0.0, 0.0), abs=1e-3)


@pytest.mark.parametrize("name", PLANAR)
def test_a_wall_stops_it(name):
    """It stalls: 5 seconds of full thrust do not move it on, and it does not tip over."""
    robot = driven(name, (0.5, 0.0, 0.0), 12.0)
    _, y, yaw = robot.pose
    assert robot.collisions >= 1
    assert robot.velocity[0] == pytest.approx(0.0, abs=0.01)
    assert (y, yaw) == pytest.approx((0.0, 0.0), abs=0.05)
