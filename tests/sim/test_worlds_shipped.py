"""The worlds that come with the package, against the figures they are made from."""

import math

import pytest

from bt_mission.common.data import names
from bt_mission.common.robot import load_robot
from sim.occupancy import OCCUPIED, rasterise
from sim.simulation import Simulation
from sim.world import load_world

SHIPPED = [
    "coloured_pillars",
    "dqn_stage1",
    "dqn_stage4",
    "empty_arena",
    "nav_arena",
    "turtlebot3_world",
]
ZONES = {"A": (-1.85, -1.76), "B": (1.85, -1.02), "C": (-1.83, 1.13), "D": (1.87, 1.87)}


def test_six_worlds_are_shipped():
    """Each is called after its file."""
    assert names("worlds") == SHIPPED
    assert [load_world(name).name for name in SHIPPED] == SHIPPED


@pytest.mark.parametrize("name", SHIPPED)
@pytest.mark.parametrize("robot", ["waffle", "burger"])
def test_both_robots_fit_at_every_spawn(name, robot):
    """They start where the world says, and touch nothing."""
    world = load_world(name)
    simulation = Simulation(world, load_robot(robot), seed=0)
    spawn = world.spawn
    assert simulation.pose == pytest.approx((spawn.x, spawn.y, math.radians(spawn.yaw)), abs=1e-5)


@pytest.mark.parametrize(
    ("name", "inside"),
    [("empty_arena", 3.84), ("dqn_stage1", 4.70), ("coloured_pillars", 4.8), ("nav_arena", 4.8)],
)
def test_arenas_are_as_wide_as_published(name, inside):
    """Between opposite walls lies the published distance."""
    walls = load_world(name).obstacles[:4]
    for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1)):
        assert min(wall.distance(x * inside / 2, y * inside / 2) for wall in walls) == (
            pytest.approx(0, abs=1e-9)
        )


@pytest.mark.parametrize("name", SHIPPED)
@pytest.mark.parametrize("robot", ["waffle", "burger"])
def test_every_obstacle_is_high_enough_for_the_lidar(name, robot):
    """A Waffle's looks at 0.132 m, a Burger's at 0.182 m; what is lower is run over unseen."""
    model = load_robot(robot)
    height = model.base_height + model.lidar.z
    assert min(obstacle.height for obstacle in load_world(name).obstacles) > height + 0.02


def test_stage_4_adds_seven_walls_and_two_cylinders_to_stage_1():
    """The outer walls are the same; inner walls are 1 m long, cylinders 0.12 m in radius."""
    stage1, stage4 = load_world("dqn_stage1"), load_world("dqn_stage4")
    assert stage4.walls[:4] == stage1.walls
    assert [o.size for o in stage4.obstacles[4:11]] == [(1, 0.15, 0.5)] * 7
    assert [(o.radius, o.height) for o in stage4.obstacles[11:]] == [(0.12, 0.25)] * 2


def test_turtlebot3_world_has_nine_columns_on_a_grid():
    """Radius 0.15 m, 1.1 m apart; the spawn is the tutorials'."""
    world = load_world("turtlebot3_world")
    grid = {(x, y) for x in (-1.1, 0, 1.1) for y in (-1.1, 0, 1.1)}
    assert {(c.x, c.y) for c in world.cylinders} == grid
    assert {c.radius for c in world.cylinders} == {0.15}
    assert (world.spawn.x, world.spawn.y) == (-2.0, -0.5)


def test_pillars_stand_in_their_colours():
    """Turquoise, green, blue and red, a metre from each axis."""
    pillars = load_world("coloured_pillars").cylinders
    assert {(p.colour, p.x, p.y) for p in pillars} == {
        ("turquoise", -1, -1),
        ("green", -1, 1),
        ("blue", 1, 1),
        ("red", 1, -1),
    }


def test_nav_arena_has_the_published_zones_walls_and_spawn():
    """Four zones of 0.40 m, eight inner walls of 1.05 m x 0.03 m x 0.25 m."""
    world = load_world("nav_arena")
    assert {zone.name: (zone.x, zone.y) for zone in world.zones} == ZONES
    assert {zone.radius for zone in world.zones} == {0.4}
    assert [o.size for o in world.obstacles[4:]] == [(1.05, 0.03, 0.25)] * 8
    assert (world.spawn.x, world.spawn.y, world.spawn.yaw) == (0.5, -0.04, 0)


def test_waffle_reaches_every_zone_of_the_nav_arena_with_room_to_spare():
    """From the spawn a way leads to each centre on which nothing comes within 0.4 m."""
    world = load_world("nav_arena")
    grid = rasterise(world)
    rows, columns = grid.cells.shape

    def cell(x: float, y: float) -> tuple[int, int]:
        return (
            int((y - grid.origin[1]) / grid.resolution),
            int((x - grid.origin[0]) / grid.resolution),
        )

    def clear(row: int, column: int) -> bool:
        if not (0 <= row < rows and 0 <= column < columns):
            return False
        x = grid.origin[0] + (column + 0.5) * grid.resolution
        y = grid.origin[1] + (row + 0.5) * grid.resolution
        return min(obstacle.distance(x, y) for obstacle in world.obstacles) > 0.4

    reached, edge = set(), [cell(world.spawn.x, world.spawn.y)]
    while edge:
        here = edge.pop()
        if here in reached or not clear(*here):
            continue
        reached.add(here)
        row, column = here
        edge += [(row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)]
    assert {name for name, at in ZONES.items() if cell(*at) in reached} == set(ZONES)
    assert all(grid.cells[cell(*at)] != OCCUPIED for at in ZONES.values())
