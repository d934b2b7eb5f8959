"""Pushes and shoves: what they do to a robot, when they end, what is refused."""

import math

import pytest

from sim.faults import FaultError
from sim.physics.physics import UnstableError
from tests.support.simulated import wait

RADIUS = 0.033
MASS = 1.37291 + 2 * 0.0285 + 2 * 0.0015 / RADIUS**2
"""Of a Waffle, with the rotors of its motors as they are felt at the rims of its wheels, kg."""


def test_a_push_sets_free_wheels_rolling(simulate):
    """20 N for 0.1 s, less 6 N of the gears, upon 4.2 kg: 0.33 m/s, or a little more by slip."""
    simulation = simulate()
    simulation.power_motors(on=False)
    simulation.push((20.0, 0.0), 0.1)
    wait(simulation, 0.1)
    gears = 2 * 0.1 / RADIUS
    assert simulation.velocity[0] == pytest.approx((20 - gears) * 0.1 / MASS, rel=0.2)


def test_it_ends_by_itself(simulate):
    """At its very step; no force is left, and the robot comes to rest."""
    simulation = simulate()
    simulation.push((10.0, 0.0), 0.5)
    base = simulation.physics.model.body("base").id
    wait(simulation, 0.5)
    assert simulation.physics.data.xfrc_applied[base][0] == pytest.approx(10.0)
    wait(simulation, 0.005)
    assert not simulation.physics.data.xfrc_applied.any()
    wait(simulation, 3.0)
    assert simulation.velocity == pytest.approx((0, 0), abs=1e-3)


def test_the_motors_hold_against_a_small_one(simulate):
    """5 N for a second move it by 2 cm, and 30 N by more than 20."""
    ways = []
    for force in (5.0, 30.0):
        simulation = simulate()
        simulation.push((force, 0.0), 1.0)
        wait(simulation, 1.0)
        ways.append(simulation.pose[0])
    assert ways[0] == pytest.approx(0.018, abs=0.005)
    assert ways[1] > 0.2


def test_it_turns_with_the_robot_or_stays_with_the_map(simulate):
    """A robot that looks along y: ahead is y of the map."""
    places = []
    for frame, force in (("robot", (20.0, 0.0)), ("map", (0.0, 20.0)), ("map", (20.0, 0.0))):
        simulation = simulate(spawn={"yaw": 90})
        simulation.push(force, 0.3, frame=frame)
        wait(simulation, 1.0)
        places.append(simulation.pose)
    assert places[0] == pytest.approx(places[1], abs=1e-4)
    assert places[0][1] > 0.05
    assert places[2][0] > 0.05


def test_a_torque_turns_it_to_the_left(simulate):
    """And a negative one to the right, by as much."""
    turned = []
    for torque in (1.0, -1.0):
        simulation = simulate()
        simulation.push((0.0, 0.0), 1.0, torque=torque)
        wait(simulation, 1.0)
        turned.append(simulation.pose[2])
    assert turned[0] > math.radians(5)
    assert turned[1] == pytest.approx(-turned[0], rel=0.05)


def test_several_add_up(simulate):
    """Two that cancel each other move nothing; the longer one is left over."""
    simulation = simulate()
    simulation.push((10.0, 0.0), 0.5)
    simulation.push((-10.0, 0.0), 0.5)
    wait(simulation, 0.5)
    assert simulation.pose == pytest.approx((0, 0, 0), abs=1e-5)


def test_a_shove_is_a_velocity_at_once(simulate):
    """Then its wheels, which turn as before, take it away: 1 m/s is braked within 10 cm."""
    simulation, turned = simulate(spawn={"yaw": 90}), simulate(spawn={"yaw": 90})
    simulation.shove((1.0, 0.0))
    assert simulation.velocity == pytest.approx((1.0, 0.0))
    assert simulation.physics.data.qvel[:2] == pytest.approx((0, 1))
    wait(simulation, 2.0)
    assert simulation.velocity == pytest.approx((0, 0), abs=1e-3)
    assert 0.02 < simulation.pose[1] < 0.1
    turned.shove((0.5, 0.0), turn=5.0, frame="map")
    assert turned.physics.data.qvel[:2] == pytest.approx((0.5, 0))
    assert turned.velocity[1] == 5.0
    wait(turned, 2.0)
    assert turned.pose[2] > math.pi / 2 + 0.05


def test_without_one_a_run_is_as_it_was(simulate, drive):
    """A push that has ended long ago leaves no trace but its way."""
    first, other = simulate(), simulate()
    first.push((0.0, 0.0), 0.1)
    for simulation in (first, other):
        drive(simulation, 2.0, 0.2, 0.3)
    assert first.pose == other.pose


@pytest.mark.parametrize(
    ("act", "expected"),
    [
        (lambda robot: robot.push((51, 0), 1), r"at most 50 N and 5 N m, got \(51, 0\) N and 0 N"),
        (lambda robot: robot.push((math.nan, 0), 1), r"got \(nan, 0\) N"),
        (lambda robot: robot.push((0, 0), 1, torque=-6), "and -6 N m"),
        (lambda robot: robot.push((1, 0), 0), "expected a push for a time above 0 s, got 0 s"),
        (lambda robot: robot.push((1, 0), math.inf), "got inf s"),
        (lambda robot: robot.push((1, 0), 1, frame="world"), "'robot' or 'map', got 'world'"),
        (lambda robot: robot.shove((6, 0)), r"at most 5 m/s and 10 rad/s, got \(6, 0\) m/s and 0"),
        (lambda robot: robot.shove((0, 0), turn=math.nan), "and nan rad/s"),
    ],
)
def test_what_cannot_be_is_refused(simulate, act, expected):
    """With what can."""
    with pytest.raises(FaultError, match=expected):
        act(simulate())


def test_physics_that_breaks_is_an_error(simulate, monkeypatch, tmp_path):
    """And no silent return to the start, as MuJoCo has it."""
    monkeypatch.chdir(tmp_path)  # where MuJoCo writes its log
    simulation = simulate()
    simulation.physics.data.qvel[0] = math.nan
    with pytest.raises(
        UnstableError, match=r"became unstable before 2\.000 s: forces are too large"
    ):
        wait(simulation, 1.0)
