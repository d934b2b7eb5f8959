"""Wheels that slip, block or have no power: what the robot does with them."""

import math

import pytest

from sim.physics.wheels import LEAST


@pytest.fixture
def driven(simulate, drive):
    """Makes a simulation with these faults of its wheels, and drives it for some seconds."""

    def driven(seconds=5.0, linear=0.2, angular=0.0, faults=None, **world):
        simulation = simulate(**world)
        simulation.faults.set("wheels", **(faults or {}))
        drive(simulation, seconds, linear, angular)
        return simulation

    return driven


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
    puddle = {"name": "puddle", "x": 0, "y": 0, "radius": 3, "friction": 0.02}
    sound, worn, bare = (
        driven(faults={"left_grip": grip, "right_grip": grip}, slippery=[puddle])
        for grip in (1.0, 0.5, 0.001)
    )
    assert worn.pose == pytest.approx(sound.pose, abs=0.01)
    assert bare.pose[0] < 0.5 * sound.pose[0]


def test_without_friction_at_all_the_physics_stays_stable(driven):
    """A place with none is one with the least that MuJoCo can do with."""
    ice, least = (
        driven(
            12.0, 0.2, 0.5, slippery=[{"name": "ice", "x": 0, "y": 0, "radius": 9, "friction": f}]
        )
        for f in (0, LEAST)
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


def test_with_both_blocked_it_stands(driven):
    """Whatever is commanded: less than a tenth of a millimetre, a hundredth of a degree."""
    both = {"left_blocked": True, "right_blocked": True}
    for command in ((0.26, 0.0), (0.0, 1.8), (-0.2, 1.0)):
        broken = driven(5.0, *command, faults=both)
        assert math.hypot(*broken.pose[:2]) < 1e-4
        assert abs(broken.pose[2]) < math.radians(0.01)


def test_mended_it_drives_on(driven, drive):
    """At the commanded speed, as exactly as before."""
    simulation = driven(2.0, faults={"left_blocked": True, "right_grip": 0.1})
    simulation.faults.clear("wheels")
    drive(simulation, 2.0, 0.2)
    assert simulation.velocity == pytest.approx((0.2, 0), abs=1e-3)


def test_without_power_a_blocked_wheel_stays_blocked(driven):
    """The motors off and on again."""
    simulation = driven(1.0, faults={"left_blocked": True})
    simulation.power_motors(on=False)
    simulation.power_motors(on=True)
    before = simulation.wheels[0][0]
    for _ in range(40):
        simulation.command(0.2, 0.0)
        simulation.physics.advance_to(simulation.physics.time_ns + 50_000_000)
    assert simulation.wheels[0][0] == pytest.approx(before, abs=1e-3)


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
