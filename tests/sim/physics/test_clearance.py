"""Clearance, contacts and poses: as they are, and as recorded states give them afterwards."""

import copy
import math
import random

import mujoco
import pytest

from sim.physics.clearance import Clearance, robot_gauge, touching
from sim.simulation import Simulation
from sim.world.loader import load_world
from tests.support.simulated import alone, two, wait

FRONT = 0.069
"""The Waffle's hull from its axle's middle, m."""

RIM = 0.144 + 0.009
"""Metres from the middle to the outer side of a wheel."""

WALL = {"name": "wall", "from": [1.05, -2], "to": [1.05, 2], "thickness": 0.1}
NEAR_WALL = {"name": "wall", "from": [0.5, -1], "to": [0.5, 1], "thickness": 0.02}


def coming(x, y, around):
    """A pillar that circles in 8 s."""
    motion = {"around": around, "period": 8}
    return {"name": "coming", "x": x, "y": y, "radius": 0.15, "motion": motion}


def step(simulation, command):
    """Command once, and let 50 ms pass."""
    simulation.command(*command)
    wait(simulation, 0.05)


@pytest.mark.parametrize(
    ("fields", "obstacle", "distance", "error"),
    [
        ({"walls": [WALL]}, "wall", 1 - FRONT, 1e-4),
        (
            {"walls": [WALL], "spawn": {"yaw": 45}},
            "wall",
            1 - (FRONT + 0.133) * math.sqrt(0.5),
            1e-3,
        ),
        (
            {"cylinders": [{"name": "pillar", "x": 0, "y": -0.5, "radius": 0.1}]},
            "pillar",
            0.4 - RIM,
            1e-3,
        ),
        (
            {"boxes": [{"name": "sill", "x": 0, "y": 0, "size": [0.02, 0.1, 0.005]}]},
            "sill",
            0.005,
            1e-4,
        ),
    ],
    ids=["ahead of the hull", "from its corner", "beside the wheel", "below the hull"],
)
def test_it_is_the_distance_in_space_from_hull_or_wheel(
    simulate, fields, obstacle, distance, error
):
    """The wheels stand out 20 mm farther than the body; the floor is no obstacle."""
    result = simulate(**fields).clearance()
    assert result.obstacle == obstacle
    assert result.distance == pytest.approx(distance, abs=error)
    assert math.dist(result.here, result.there) == pytest.approx(result.distance)


def test_the_nearest_points_are_on_the_hull_and_on_the_obstacle(simulate):
    """In the map."""
    result = simulate(walls=[WALL]).clearance()
    assert result.here[0] == pytest.approx(FRONT, abs=1e-4)
    assert result.there[0] == pytest.approx(1.0)


def test_what_is_out_of_reach_is_not_looked_at(simulate):
    """0.9 m away: nothing within 0.5 m, and nothing in an empty world."""
    simulation = simulate(walls=[WALL])
    assert simulation.clearance(within=0.5) == Clearance(0.5)
    assert simulation.clearance(within=2).obstacle == "wall"
    assert simulate().clearance() == Clearance(math.inf)


def test_other_robots_count_by_their_bodies_and_not_by_their_screens(make_world, waffle):
    """Nose to nose, 2 m between the axles; each measures the same."""
    fleet = Simulation(make_world(), two(waffle, yaw=180), seed=1)
    for robot, other in (("one", "two"), ("two", "one")):
        result = fleet[robot].clearance()
        assert result.obstacle == other
        assert result.distance == pytest.approx(2 - 2 * FRONT, abs=1e-3)


def nearest_of_all(simulation):
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
    wall = {"name": "wall", "from": [1.8, -2], "to": [1.8, 2], "thickness": 0.1}
    simulation = simulate(cylinders=[coming(1.0, 0.4, [0.5, 0.0])], walls=[wall], props=2)
    draw = random.Random(5)
    box, tight = None, 0
    for number in range(400):
        if number % 40 == 0:
            command = draw.uniform(-0.2, 0.26), draw.uniform(-1.8, 1.8)
            simulation.clearance()
        if number % 70 == 69:
            if box is not None:
                box.remove()
            size = (draw.uniform(0.1, 0.5), 0.1, 0.3)
            box = simulation.physics.props.place("box", draw.uniform(-2, 1), 1.0, size=size)
        step(simulation, command)
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
    wall = {"name": "wall", "from": [-1.1, -2], "to": [-1.1, 2], "thickness": 0.1}
    simulation = simulate(cylinders=[coming(0.9, 0.9, [0.9, 0.5])], walls=[wall], props=2)
    draw = random.Random(6)
    box, nearest = None, set()
    for number in range(300):
        if number % 30 == 0:
            command = draw.uniform(-0.2, 0.26), draw.uniform(-1.8, 1.8)
        if number % 60 == 20 and box is not None:
            box.remove()
        if number % 60 == 40:
            size = (draw.uniform(0.1, 0.5), 0.1, 0.3)
            box = simulation.physics.props.place(
                "box", draw.uniform(-0.3, 0.3), -0.5, size=size, even_into_the_robot=True
            )
        step(simulation, command)
        anew = robot_gauge(simulation.physics.model, simulation._gauge._names).measure(
            simulation.physics.data
        )
        assert simulation.clearance() == anew
        nearest.add(anew.obstacle)
    assert nearest == {"coming", "wall", "box"}


# ---- looking back ------------------------------------------------------------------------


def test_pose_velocity_and_clearance_are_those_of_the_instant(waffle):
    """Bit for bit, among moving obstacles, when the run is over."""
    simulation = alone(load_world("dqn_stage4"), waffle, seed=1)
    seen = []
    for number in range(100):
        step(simulation, (0.2, 0.8 if number % 20 < 10 else -0.8))
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
    assert simulation.clearance().distance == pytest.approx(0.9 - FRONT, abs=1e-4)
    box.move_at(0.5, 0.0)
    wait(simulation, 1.0)
    moved = simulation.record()
    box.remove()
    assert simulation.clearance() == Clearance(math.inf)
    simulation.physics.props.place("pillar", 0.5, 0.0, radius=0.1)
    other = simulation.record()
    results = [review.clearance(state) for state in (other, moved, placed, nothing, placed)]
    assert [result.obstacle for result in results] == ["pillar", "box", "box", None, "box"]
    assert [round(result.distance, 3) for result in results[:3]] == [0.331, 1.331, 0.831]
    assert simulation.clearance() == results[0]


def test_a_wall_that_is_pushed_against_is_penetrated_and_named_with_its_place(simulate, drive):
    """By less than a millimetre, as contacts are a little soft; before that, nothing touches."""
    simulation = simulate(walls=[NEAR_WALL])
    review = simulation.review()
    before = simulation.record()
    drive(simulation, 4.0, linear=0.2)
    assert review.contacts(before) == {}
    (name, place), *none = review.contacts(simulation.record()).items()
    assert (name, none) == ("wall", [])
    assert place[0] == pytest.approx(0.49, abs=1e-3)
    result = simulation.clearance()
    assert -1e-3 < result.distance < 0
    assert result.obstacle == "wall"


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
    wait(simulation, 0.005)
    assert state != simulation.record()


def test_each_robot_of_a_fleet_has_a_reviewer_of_its_own(make_world, waffle):
    """One record is of all of them."""
    fleet = Simulation(make_world(), two(waffle), seed=1)
    state = fleet.physics.record()
    for robot in fleet.robots:
        assert robot.review().pose(state) == robot.pose
        assert robot.review().clearance(state) == robot.clearance()
