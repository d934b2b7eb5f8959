"""Wheels that slip, block or have no power, on the floor and on slippery places."""

import math

import pytest

from sim.physics.wheels import LEAST

ICE = {"name": "ice", "x": 0, "y": 0, "radius": 0.6, "friction": 0.02}


@pytest.fixture
def driven(simulate, drive):
    """Makes a simulation with these faults of its wheels, and drives it for some seconds."""

    def driven(seconds=5.0, linear=0.2, angular=0.0, faults=None, **world):
        simulation = simulate(**world)
        simulation.faults.set("wheels", **(faults or {}))
        drive(simulation, seconds, linear, angular)
        return simulation

    return driven


def test_wheels_spin_where_it_is_slippery(driven, drive):
    """Starting on ice, odometry runs ahead of the truth; it does so again after a reset."""
    ice, floor = driven(2.0, slippery=[ICE]), driven(2.0)
    assert ice.odometry.x == pytest.approx(floor.odometry.x, abs=0.01)
    assert floor.pose[0] == pytest.approx(floor.odometry.x, abs=0.001)
    assert ice.pose[0] < 0.8 * ice.odometry.x
    first = ice.pose
    ice.physics.reset()
    drive(ice, 2.0, linear=0.2)
    assert ice.pose == first


def test_beside_a_slippery_place_they_grip_as_ever(driven):
    """A robot that does not come near drives as without it."""
    away, floor = driven(2.0, 0.2, 0.3, slippery=[{**ICE, "y": 5}]), driven(2.0, 0.2, 0.3)
    assert away.pose == pytest.approx(floor.pose, abs=1e-6)


def test_the_lidar_does_not_see_a_slippery_place_and_nobody_runs_into_it(driven):
    """It is a mark on the floor."""
    simulation = driven(2.0, slippery=[{**ICE, "x": 0.5}])
    assert not (simulation.scan(0) < 3.5).any()
    assert simulation.collisions == 0


def test_a_wheel_that_grips_less_turns_and_moves_less(driven):
    """One at 0.02 instead of 1: the robot lags and turns to that side; its odometry does not."""
    sound, broken = driven(), driven(faults={"left_grip": 0.02})
    assert sound.pose == pytest.approx((0.978, 0, 0), abs=0.002)
    assert broken.distance_travelled < 0.9 * sound.distance_travelled
    assert broken.pose[2] > math.radians(30)
    assert broken.odometry.x == pytest.approx(sound.odometry.x, abs=0.001)
    assert broken.odometry.yaw == pytest.approx(0, abs=0.01)


def test_wheels_without_any_grip_spin_on_the_spot(driven):
    """5 s at 0.2 m/s: less than 15 cm, and 98 cm of odometry."""
    broken = driven(faults={"left_grip": 0.0, "right_grip": 0.0})
    assert broken.distance_travelled < 0.15
    assert broken.odometry.x == pytest.approx(0.977, abs=0.002)


def test_on_a_slippery_place_the_lower_counts(driven):
    """A wheel at 0.5 on a puddle of 0.02 is as one without fault; at 0.001 it is not."""
    sound, worn, bare = (
        driven(faults={"left_grip": grip, "right_grip": grip}, slippery=[{**ICE, "radius": 3}])
        for grip in (1.0, 0.5, 0.001)
    )
    assert worn.pose == pytest.approx(sound.pose, abs=0.01)
    assert bare.pose[0] < 0.5 * sound.pose[0]


def test_without_friction_at_all_the_physics_stays_stable(driven):
    """A place with none is one with the least that MuJoCo can do with."""
    ice, least = (
        driven(12.0, 0.2, 0.5, slippery=[{**ICE, "radius": 9, "friction": friction}])
        for friction in (0, LEAST)
    )
    assert ice.pose == least.pose


def test_a_blocked_wheel_does_not_turn(driven):
    """Less than a thousandth of a radian in 5 s; the robot turns about it, seen by odometry."""
    broken = driven(faults={"left_blocked": True})
    left, right = broken.wheels[0]
    assert abs(left) < 1e-3
    assert right == pytest.approx(29.6, abs=0.1)
    # 0.2 m/s of the right wheel round the left one, 0.288 m away.
    assert broken.velocity[1] == pytest.approx(0.2 / 0.288, rel=0.02)
    assert broken.odometry.yaw == pytest.approx(broken.pose[2], abs=0.05)
    left_wheel = broken.physics.data.body("wheel_left").xpos[:2]
    assert left_wheel == pytest.approx((0, 0.144), abs=0.02)


@pytest.mark.parametrize("command", [(0.26, 0.0), (0.0, 1.8), (-0.2, 1.0)])
def test_with_both_blocked_it_stands(driven, command):
    """Whatever is commanded: less than a tenth of a millimetre, a hundredth of a degree."""
    broken = driven(5.0, *command, faults={"left_blocked": True, "right_blocked": True})
    assert math.hypot(*broken.pose[:2]) < 1e-4
    assert abs(broken.pose[2]) < math.radians(0.01)


def test_without_power_a_blocked_wheel_stays_blocked_until_it_is_mended(driven, drive):
    """The motors off and on again; then it drives at the commanded speed, as exactly as before."""
    simulation = driven(1.0, faults={"left_blocked": True, "right_grip": 0.1})
    simulation.power_motors(on=False)
    simulation.power_motors(on=True)
    before = simulation.wheels[0][0]
    drive(simulation, 2.0, 0.2)
    assert simulation.wheels[0][0] == pytest.approx(before, abs=1e-3)
    simulation.faults.clear("wheels")
    drive(simulation, 2.0, 0.2)
    assert simulation.velocity == pytest.approx((0.2, 0), abs=1e-3)


def test_faults_come_and_go_in_the_run_and_repeat(driven, drive):
    """Two runs with the same faults at the same times are the same, bit for bit."""
    poses = []
    for _ in range(2):
        simulation = driven(1.0)
        simulation.faults.set("wheels", right_grip=0.05)
        drive(simulation, 1.0, 0.2, 0.5)
        simulation.faults.set("wheels", right_grip=1.0, left_blocked=True)
        drive(simulation, 1.0, 0.2, 0.5)
        simulation.faults.clear()
        drive(simulation, 1.0, 0.2, 0.5)
        poses.append(simulation.pose)
    assert poses[0] == poses[1]
