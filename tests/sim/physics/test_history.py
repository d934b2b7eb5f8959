"""Looking back: what recorded states say afterwards is what was so at their instants."""

import copy

import pytest

from sim.physics.spawn import RobotSpawn
from sim.simulation import Simulation
from sim.world.loader import load_world
from sim.world.world import Spawn
from tests.support.simulated import alone


def test_pose_velocity_and_clearance_are_those_of_the_instant(waffle):
    """Bit for bit, among moving obstacles, when the run is over."""
    simulation = alone(load_world("dqn_stage4"), waffle, seed=1)
    seen = []
    for step in range(100):
        simulation.command(0.2, 0.8 if step % 20 < 10 else -0.8)
        simulation.physics.advance_to(simulation.physics.time_ns + 50_000_000)
        now = (simulation.pose, simulation.velocity, simulation.clearance())
        seen.append((simulation.record(), simulation.physics.time_ns, now))
    review = simulation.review()
    for state, time_ns, now in reversed(seen):
        assert state.time_ns == time_ns
        assert (review.pose(state), review.velocity(state), review.clearance(state)) == now


def test_props_are_those_of_the_instant(simulate):
    """One that has moved, one that has gone, and a body that has become something else."""
    simulation = simulate(props=1)
    review = simulation.review()
    nothing = simulation.record()
    box = simulation.physics.props.place("box", 1.0, 0.0, size=(0.2, 0.2, 0.3))
    placed = simulation.record()
    box.move_at(0.5, 0.0)
    simulation.physics.advance_to(simulation.physics.time_ns + 1_000_000_000)
    moved = simulation.record()
    box.remove()
    simulation.physics.props.place("pillar", 0.5, 0.0, radius=0.1)
    other = simulation.record()
    results = [review.clearance(state) for state in (other, moved, placed, nothing, placed)]
    assert [result.obstacle for result in results] == ["pillar", "box", "box", None, "box"]
    assert [round(result.distance, 3) for result in results[:3]] == [0.331, 1.331, 0.831]
    assert simulation.clearance() == results[0]


def test_contacts_are_told_with_their_places(simulate, drive):
    """Before it meets the wall, and while it pushes."""
    wall = {"name": "wall", "from": [0.5, -1], "to": [0.5, 1], "thickness": 0.02}
    simulation = simulate(walls=[wall])
    review = simulation.review()
    before = simulation.record()
    drive(simulation, 4.0, linear=0.2)
    assert review.contacts(before) == {}
    (name, place), *none = review.contacts(simulation.record()).items()
    assert (name, none) == ("wall", [])
    assert place[0] == pytest.approx(0.49, abs=1e-3)


def test_looking_back_changes_nothing_in_the_run(simulate, drive):
    """Two runs, one of them reviewed all the time."""
    first, other = (simulate(cylinders=[{"x": 1, "y": 0, "radius": 0.1}]) for _ in range(2))
    review = first.review()
    for _ in range(20):
        for simulation in (first, other):
            drive(simulation, 0.2, 0.2, 0.3)
        review.contacts(first.record())
        first.clearance()
    assert first.record() == other.record()


def test_states_are_equal_where_all_of_it_is(simulate):
    """And a copy is as good as the state itself."""
    simulation = simulate(props=1)
    simulation.physics.props.place("box", 1.0, 0.0, radius=0.1)
    state = simulation.record()
    assert state == simulation.record()
    assert simulation.review().clearance(copy.deepcopy(state)) == simulation.clearance()
    simulation.physics.advance_to(simulation.physics.time_ns + 5_000_000)
    assert state != simulation.record()


def test_each_robot_of_a_fleet_has_a_reviewer_of_its_own(make_world, waffle):
    """One record is of all of them."""
    entrants = [RobotSpawn(waffle, "one", Spawn(x=-1)), RobotSpawn(waffle, "two", Spawn(x=1, y=1))]
    fleet = Simulation(make_world(), entrants, seed=1)
    state = fleet.physics.record()
    for robot in fleet.robots:
        assert robot.review().pose(state) == robot.pose
        assert robot.review().clearance(state) == robot.clearance()
