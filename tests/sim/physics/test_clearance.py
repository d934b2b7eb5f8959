"""Clearance: the true room between the robot and all that it could touch, and what is so near."""

import math
import random

import mujoco
import pytest

from sim.physics.clearance import Clearance, robot_gauge, touching
from sim.physics.spawn import RobotSpawn
from sim.robot.robot import SimulatedRobot
from sim.simulation import Simulation
from sim.world.loader import load_world
from sim.world.world import Spawn
from tests.support.simulated import alone

FRONT, HALF_WIDTH = 0.069, 0.153
"""The Waffle's hull from its axle's middle, m."""

RIM = 0.144 + 0.009
"""Metres from the middle to the outer side of a wheel."""


def test_ahead_it_is_the_distance_from_the_hull(simulate):
    """A wall whose face is 1 m ahead of the axle."""
    wall = {"name": "wall", "from": [1.05, -2], "to": [1.05, 2], "thickness": 0.1}
    result = simulate(walls=[wall]).clearance()
    assert result.distance == pytest.approx(1 - FRONT, abs=1e-4)
    assert result.obstacle == "wall"
    assert result.here is not None
    assert result.there is not None
    assert result.here[0] == pytest.approx(FRONT, abs=1e-4)
    assert result.there[0] == pytest.approx(1.0)
    assert math.dist(result.here, result.there) == pytest.approx(result.distance)


def test_beside_it_is_the_distance_from_the_wheel(simulate):
    """The wheels stand out 20 mm farther than the body."""
    pillar = {"name": "pillar", "x": 0, "y": -0.5, "radius": 0.1}
    result = simulate(cylinders=[pillar]).clearance()
    assert result.distance == pytest.approx(0.4 - RIM, abs=1e-3)


def test_a_corner_counts_where_it_is_nearest(simulate):
    """Turned by 45 degrees, the front corner is 1 m less its own reach away."""
    wall = {"name": "wall", "from": [1.05, -2], "to": [1.05, 2], "thickness": 0.1}
    result = simulate(walls=[wall], spawn={"yaw": 45}).clearance()
    reach = (FRONT + 0.133) * math.cos(math.radians(45))
    assert result.distance == pytest.approx(1 - reach, abs=1e-3)


def test_what_is_out_of_reach_is_not_looked_at(simulate):
    """0.9 m away: nothing within 0.5 m, and nothing in an empty world."""
    wall = {"name": "wall", "from": [1, -2], "to": [1, 2], "thickness": 0.1}
    simulation = simulate(walls=[wall])
    assert simulation.clearance(within=0.5) == Clearance(0.5)
    assert simulation.clearance(within=2).obstacle == "wall"
    assert simulate().clearance() == Clearance(math.inf)


def test_the_floor_is_no_obstacle_and_a_bar_overhead_is(simulate):
    """What counts is the distance in space: 5 mm of height between a sill and the hull."""
    sill = {"name": "sill", "x": 0.0, "y": 0.0, "size": [0.02, 0.1, 0.005]}
    result = simulate(boxes=[sill]).clearance()
    assert result.obstacle == "sill"
    assert result.distance == pytest.approx(0.005, abs=1e-4)


def test_pushing_on_against_a_wall_it_is_below_zero(simulate, drive):
    """By less than a millimetre: contacts are a little soft."""
    wall = {"name": "wall", "from": [0.5, -1], "to": [0.5, 1], "thickness": 0.02}
    simulation = simulate(walls=[wall])
    drive(simulation, 4.0, linear=0.2)
    result = simulation.clearance()
    assert -1e-3 < result.distance < 0
    assert result.obstacle == "wall"


def test_other_robots_count_by_their_bodies_and_not_by_their_screens(make_world, waffle):
    """Nose to nose, 2 m between the axles; each measures the same."""
    entrants = [
        RobotSpawn(waffle, "one", Spawn(x=-1)),
        RobotSpawn(waffle, "two", Spawn(x=1, yaw=180)),
    ]
    fleet = Simulation(make_world(), entrants, seed=1)
    for robot, other in (("one", "two"), ("two", "one")):
        result = fleet[robot].clearance()
        assert result.obstacle == other
        assert result.distance == pytest.approx(2 - 2 * FRONT, abs=1e-3)


def test_a_prop_counts_while_it_is_there(simulate):
    """It is measured at the same instant."""
    simulation = simulate(props=2)
    box = simulation.physics.props.place("box", 1.0, 0.0, size=(0.2, 0.2, 0.3))
    assert simulation.clearance().obstacle == "box"
    assert simulation.clearance().distance == pytest.approx(0.9 - FRONT, abs=1e-4)
    box.remove()
    assert simulation.clearance() == Clearance(math.inf)


def nearest_of_all(simulation: SimulatedRobot) -> float:
    """The least distance over every pair of geoms, none left out."""
    model, data = simulation.physics.model, simulation.physics.data
    others = [g for g in range(model.ngeom) if model.geom(g).name.startswith("obstacle/")]
    return min(
        mujoco.mj_geomDistance(model, data, geom, other, 100.0, None)
        for geom in touching(model)
        for other in others
    )


@pytest.mark.parametrize("world", ["dqn_stage4", "turtlebot3_house"])
def test_what_it_leaves_out_is_never_the_nearest(waffle, drive, world):
    """It looks at a few obstacles only; the result is that of looking at all of them."""
    simulation = alone(load_world(world), waffle, seed=1)
    for _ in range(40):
        drive(simulation, 0.5, 0.2, 0.6)
        assert simulation.clearance().distance == pytest.approx(
            nearest_of_all(simulation), abs=1e-9
        )


def test_the_lower_bound_never_exceeds_the_clearance(simulate):
    """Whatever moves: the robot, obstacles, boxes that come, grow and go. It is often above 0."""
    coming = {
        "name": "coming",
        "x": 1.0,
        "y": 0.4,
        "radius": 0.15,
        "motion": {"around": [0.5, 0.0], "period": 8},
    }
    wall = {"name": "wall", "from": [1.8, -2], "to": [1.8, 2], "thickness": 0.1}
    simulation = simulate(cylinders=[coming], walls=[wall], props=2)
    draw = random.Random(5)
    box, tight = None, 0
    for step in range(400):
        if step % 40 == 0:
            command = draw.uniform(-0.2, 0.26), draw.uniform(-1.8, 1.8)
            simulation.clearance()
        if step % 70 == 69:
            if box is not None:
                box.remove()
            size = (draw.uniform(0.1, 0.5), 0.1, 0.3)
            box = simulation.physics.props.place("box", draw.uniform(-2, 1), 1.0, size=size)
        simulation.command(*command)
        simulation.physics.advance_to(simulation.physics.time_ns + 50_000_000)
        bound = simulation.clearance_at_least()
        known = simulation._gauge._known  # measuring would start it anew
        clearance = simulation.clearance().distance
        simulation._gauge._known = known
        assert bound <= clearance + 1e-9
        tight += bound > 0.5 * clearance
    assert tight > 50


def test_turning_on_the_spot_does_not_use_the_bound_up(simulate, drive):
    """A ball round the robot stays where it is, so the bound stays that of the ball."""
    simulation = simulate(walls=[{"name": "wall", "from": [2, -3], "to": [2, 3], "thickness": 0.1}])
    clearance = simulation.clearance().distance
    drive(simulation, 1.5, 0.0, 1.8)
    assert simulation.clearance_at_least() > 0.85 * clearance


def test_what_was_near_before_does_not_change_what_is_measured(simulate):
    """One measurement after another gives what the first of a new gauge gives, to the last bit."""
    coming = {
        "name": "coming",
        "x": 0.9,
        "y": 0.9,
        "radius": 0.15,
        "motion": {"around": [0.9, 0.5], "period": 8},
    }
    wall = {"name": "wall", "from": [-1.1, -2], "to": [-1.1, 2], "thickness": 0.1}
    simulation = simulate(cylinders=[coming], walls=[wall], props=2)
    draw = random.Random(6)
    box, nearest = None, set()
    for step in range(300):
        if step % 30 == 0:
            command = draw.uniform(-0.2, 0.26), draw.uniform(-1.8, 1.8)
        if step % 60 == 20 and box is not None:
            box.remove()
        if step % 60 == 40:
            size = (draw.uniform(0.1, 0.5), 0.1, 0.3)
            box = simulation.physics.props.place(
                "box", draw.uniform(-0.3, 0.3), -0.5, size=size, even_into_the_robot=True
            )
        simulation.command(*command)
        simulation.physics.advance_to(simulation.physics.time_ns + 50_000_000)
        anew = robot_gauge(simulation.physics.model, simulation._gauge._names).measure(
            simulation.physics.data
        )
        assert simulation.clearance() == anew
        nearest.add(anew.obstacle)
    assert nearest == {"coming", "wall", "box"}
