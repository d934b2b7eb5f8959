"""The worlds that come with the package, against the figures they are made from."""

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from bt_mission.base.files import names
from bt_mission.robots.model import load_robot
from sim.world.loader import load_world, unseen
from sim.world.world import World
from tests.support.simulated import alone
from tests.support.thorough import sample

ARENAS = {
    "empty_arena": 3.84,
    "explore_arena": 3.84,
    "obstacle_avoidance": 3.84,
    "fig_of_eight": 3.84,
    "dqn_stage1": 4.70,
    "coloured_pillars": 4.8,
    "nav_arena": 4.8,
}
"""The published distances between opposite walls, m."""

OTHERS = {"fetch_arena", "wide_arena", "turtlebot3_house", "turtlebot3_world"}
SHIPPED = sorted({*ARENAS, *OTHERS, "dqn_stage2", "dqn_stage3", "dqn_stage4"})
LOW = {"explore_arena", "fig_of_eight", "obstacle_avoidance"}
"""The course's arena with walls of 0.16 m, over which a Burger looks."""

ZONES = {"A": (-1.85, -1.76), "B": (1.85, -1.02), "C": (-1.83, 1.13), "D": (1.87, 1.87)}


def test_these_worlds_are_shipped():
    """Each is called after its file."""
    assert names("worlds") == SHIPPED
    assert [load_world(name).name for name in SHIPPED] == SHIPPED


@pytest.mark.parametrize("name", SHIPPED)
@pytest.mark.parametrize("robot", ["waffle", "burger"])
def test_both_robots_fit_at_every_spawn(name, robot):
    """They start where the world says, and touch nothing."""
    world = load_world(name)
    simulation = alone(world, load_robot(robot), seed=0)
    spawn = world.spawn
    assert simulation.pose == pytest.approx((spawn.x, spawn.y, math.radians(spawn.yaw)), abs=1e-5)


@pytest.mark.parametrize(("name", "inside"), ARENAS.items())
def test_arenas_are_as_wide_as_published(name, inside):
    """Between opposite walls lies the published distance."""
    walls = load_world(name).obstacles[:4]
    for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1)):
        nearest = min(wall.distance(x * inside / 2, y * inside / 2) for wall in walls)
        assert nearest == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("name", SHIPPED)
@pytest.mark.parametrize("robot", ["waffle", "burger"])
def test_every_obstacle_is_high_enough_for_the_lidar(name, robot):
    """A Waffle's looks at 0.132 m, a Burger's at 0.182 m; of the low arenas it is warned."""
    model, world = load_robot(robot), load_world(name)
    if robot == "burger" and name in LOW:
        (warning,) = unseen(world, model)
        assert "looks 0.182 m above the floor and over 'north wall'" in warning
        return
    assert unseen(world, model) == []
    height = model.base_height + model.lidar.z
    assert min(obstacle.height for obstacle in world.obstacles) > height + 0.02


CORNERS = [(x, y) for x in (1, -1) for y in (1, -1)]
GRID = [(x, y) for x in (-1.1, 0, 1.1) for y in (-1.1, 0, 1.1)]
PILLARS = [("turquoise", -1, -1), ("green", -1, 1), ("blue", 1, 1), ("red", 1, -1)]
BEACONS = [("green", 1.8, 1.8), ("yellow", 1.17, -0.7), ("blue", -0.91, 1.29)]


@pytest.mark.parametrize(
    ("name", "radius", "cylinders"),
    [
        ("explore_arena", 0.1, [*BEACONS, ("red", -0.655, -1.13)]),
        ("obstacle_avoidance", 0.1, [(0, 0.78), (0, -0.78), (0.78, 0), (-0.78, 0)]),
        ("fig_of_eight", 0.1, [("blue", 0, -0.5), ("red", 0, 0.5)]),
        ("turtlebot3_world", 0.15, GRID),
        ("coloured_pillars", 0.15, PILLARS),
        ("dqn_stage2", 0.15, CORNERS),
        ("dqn_stage3", 0.15, CORNERS),
    ],
)
def test_cylinders_stand_where_they_are_published(name, radius, cylinders):
    """Beacons, columns and pillars, with their colours if these are published; m."""
    placed = [(c.colour, c.x, c.y)[3 - len(cylinders[0]) :] for c in load_world(name).cylinders]
    assert sorted(placed) == sorted(cylinders)
    assert {c.radius for c in load_world(name).cylinders} == {radius}


@pytest.mark.parametrize(
    ("name", "sizes"),
    [
        ("explore_arena", [(0.88, 0.01, 0.18)] * 7 + [(0.44, 0.01, 0.18)] * 9),
        ("obstacle_avoidance", [(0.44, 0.01, 0.18)] * 8),
        ("nav_arena", [(1.05, 0.03, 0.25)] * 8),
        ("dqn_stage4", [(1, 0.15, 0.5)] * 7),
    ],
)
def test_inner_walls_have_the_published_sizes(name, sizes):
    """Length, thickness and height, m; the four outer walls are the first."""
    world = load_world(name)
    assert [wall.size for wall in world.obstacles[4 : len(world.walls)]] == sizes
    if name in LOW:
        assert [wall.size for wall in world.obstacles[:4]] == [(4, 0.08, 0.16)] * 4


@pytest.mark.parametrize(
    ("name", "spawn"),
    [
        ("explore_arena", (-1.42, -0.5, 0)),
        ("nav_arena", (0.5, -0.04, 0)),
        ("turtlebot3_house", (-2.0, -0.5, 0)),
        ("turtlebot3_world", (-2.0, -0.5, 0)),
    ],
)
def test_robots_start_where_it_is_published(name, spawn):
    """Metres and degrees; in the last two, as in the tutorials."""
    start = load_world(name).spawn
    assert (start.x, start.y, start.yaw) == spawn


def test_stages_2_to_4_add_to_stage_1_what_stands_or_moves():
    """In stage 3 the four cylinders of stage 2 come round in 80 s; stage 4 has two others."""
    stage1, stage2, stage3, stage4 = (load_world(f"dqn_stage{n}") for n in (1, 2, 3, 4))
    assert stage2.walls == stage3.walls == stage4.walls[:4] == stage1.walls
    assert stage2.moving == ()
    assert len(stage3.moving) == 4
    for pillar in stage3.moving:
        assert pillar.motion is not None
        assert pillar.motion.at(40.0)[:2] == pytest.approx((-pillar.x, -pillar.y))
    assert [(o.radius, o.height) for o in stage4.obstacles[11:]] == [(0.12, 0.25)] * 2


def test_what_moves_in_stage_4_goes_at_a_tenth_of_a_metre_a_second_and_far_from_the_spawn():
    """Two cylinders, 1.5 m and more from the spawn at all times, and clear of all walls."""
    world = load_world("dqn_stage4")
    still = [obstacle for obstacle in world.obstacles if obstacle.motion is None]
    assert [pillar.name for pillar in world.moving] == ["obstacle 1", "obstacle 2"]
    for pillar in world.moving:
        assert pillar.motion is not None
        for tenth in range(600):
            x, y, vx, vy = pillar.motion.at(tenth / 10)
            assert math.hypot(vx, vy) == pytest.approx(0.1)
            assert math.hypot(x, y) > 1.5
            assert min(wall.distance(x, y) for wall in still) > pillar.radius + 0.05


def test_the_house_has_the_published_walls():
    """0.15 m thick, 2.5 m high, 15 m x 10.6 m over all."""
    world = load_world("turtlebot3_house")
    walls = world.obstacles[: len(world.walls)]
    assert {wall.size[1:] for wall in walls} == {(0.15, 2.5)}
    for x, y in ((7.5, 0), (-7.5, 0), (0, 5.3), (0, -5.3)):
        assert min(wall.distance(x, y) for wall in walls) == pytest.approx(0, abs=1e-9)


def reached(world: World, clearance: float, step: float = 0.05) -> Callable[[float, float], bool]:
    """Tells where one gets from the spawn without coming nearer to anything than that, m."""
    still = [obstacle for obstacle in world.obstacles if obstacle.motion is None]

    def clear(column: int, row: int) -> bool:
        x, y = world.spawn.x + column * step, world.spawn.y + row * step
        return (
            abs(x) < world.size[0] / 2
            and abs(y) < world.size[1] / 2
            and all(obstacle.distance(x, y) > clearance for obstacle in still)
        )

    been, edge = set(), [(0, 0)]
    while edge:
        here = edge.pop()
        if here not in been and clear(*here):
            been.add(here)
            column, row = here
            edge += [(column + 1, row), (column - 1, row), (column, row + 1), (column, row - 1)]
    return lambda x, y: (
        (round((x - world.spawn.x) / step), round((y - world.spawn.y) / step)) in been
    )


@pytest.mark.parametrize(
    ("name", "clearance"), sample([("nav_arena", 0.4), ("turtlebot3_house", 0.4)], 4)
)
def test_waffle_reaches_every_zone_with_room_to_spare(name, clearance):
    """From the spawn a way leads to each centre on which nothing comes within 0.4 m."""
    world = load_world(name)
    is_reached = reached(world, clearance, step=0.05)
    assert [zone.name for zone in world.zones if not is_reached(zone.x, zone.y)] == []


@pytest.mark.thorough
def test_waffle_reaches_all_sixteen_zones_of_the_explore_arena():
    """On a way on which it can turn round anywhere: its corners sweep 0.238 m."""
    is_reached = reached(load_world("explore_arena"), 0.25, step=0.02)
    edges = [-1.92 + 0.96 * n for n in range(5)]
    for left, right in pairwise(edges):
        for low, high in pairwise(edges):
            inside = [
                (x, y)
                for x in np.arange(left + 0.1, right, 0.1)
                for y in np.arange(low + 0.1, high, 0.1)
                if is_reached(x, y)
            ]
            assert inside, f"the zone around ({(left + right) / 2:g}, {(low + high) / 2:g})"


def test_both_arenas_have_the_published_zones_and_the_wide_one_room_for_a_husky():
    """So patrol runs in it unchanged; 0.6 m are free around each zone."""
    world = load_world("wide_arena")
    for arena in (load_world("nav_arena"), world):
        assert {zone.name: (zone.x, zone.y) for zone in arena.zones} == ZONES
    assert {zone.radius for zone in load_world("nav_arena").zones} == {0.4}
    assert load_robot("husky").turning_radius < 0.6
    for zone in world.zones:
        assert min(thing.distance(zone.x, zone.y) for thing in world.obstacles) > 0.6
