"""Distances to shapes, and the map of a world made of them, cell by cell."""

import math

import numpy as np
import pytest

from sim.world.loader import load_world
from sim.world.occupancy import OCCUPIED, rasterise
from sim.world.shapes import Obstacle
from sim.world.world import World

SIZE = (2.0, 0.2, 0.5)
LYING, TURNED = (
    Obstacle.box("wall", 1, 1, yaw=yaw, size=SIZE, colour="white") for yaw in (0.0, math.pi / 2)
)
PILLAR = Obstacle.cylinder("pillar", 0, 0, radius=0.15, height=0.5, colour="red")


@pytest.mark.parametrize(
    ("obstacle", "place", "distance"),
    [
        (LYING, (1, 1.6), 0.5),
        (LYING, (2.3, 1.5), 0.5),
        (LYING, (1, 1), -0.1),
        (TURNED, (1, 2.5), 0.5),
        (TURNED, (1.6, 1), 0.5),
        (PILLAR, (3, 4), 4.85),
    ],
    ids=["face", "corner", "inside", "turned: end", "turned: face", "rim"],
)
def test_distances_are_those_to_the_footprint(obstacle, place, distance):
    """From faces, corners and rims; in a box, minus the way out across its thinner side."""
    assert obstacle.distance(*place) == pytest.approx(distance)


def world(**fields: object) -> World:
    """A floor of 1.0 m x 0.5 m with something on it."""
    return World.model_validate(
        {"name": "w", "size": [1.0, 0.5], "spawn": {"x": -0.45, "y": -0.2}, **fields}
    )


def occupied(world: World, resolution: float = 0.1) -> set[tuple[int, int]]:
    """Rows and columns of the occupied cells."""
    cells = rasterise(world, resolution).cells
    return {(int(row), int(column)) for row, column in np.argwhere(cells == OCCUPIED)}


def test_rows_run_along_y_and_columns_along_x():
    """The origin is the corner with the smallest x and y."""
    drawn = rasterise(world(), 0.1)
    assert drawn.cells.shape == (5, 10)
    assert drawn.origin == (-0.5, -0.25)
    box = {"x": 0.45, "y": -0.2, "size": [0.02, 0.02, 0.1]}
    assert occupied(world(boxes=[box])) == {(0, 9)}


THIN = {"from": [-0.3, 0.02], "to": [0.28, 0.02], "thickness": 0.003}
SLANTING = {"from": [-0.14, -0.17], "to": [0.07, 0.04], "thickness": 0.002}


@pytest.mark.parametrize(
    ("fields", "cells"),
    [
        ({"boxes": [{"x": 0.0, "y": 0.0, "size": [0.2, 0.1, 0.1]}]}, {(2, 4), (2, 5)}),
        ({"walls": [THIN]}, {(2, column) for column in range(2, 8)}),
        ({"walls": [SLANTING]}, {(0, 3), (1, 3), (1, 4), (2, 4), (2, 5)}),
        (
            {"cylinders": [{"x": 0.05, "y": 0.0, "radius": 0.12}]},
            {(row, column) for row in range(1, 4) for column in range(4, 7)},
        ),
        (
            {"cylinders": [{"x": 0.05, "y": 0.0, "radius": 0.06}]},
            {(1, 5), (3, 5), (2, 4), (2, 5), (2, 6)},
        ),
    ],
    ids=["ends at a cell's edge", "3 mm thin", "slanting", "round", "round, without its corners"],
)
def test_a_shape_touches_just_the_cells_that_it_crosses(fields, cells):
    """Also one that is thinner than a cell: it is enough to stop a robot."""
    assert occupied(world(**fields)) == cells


@pytest.mark.parametrize("name", ["nav_arena", "dqn_stage4", "turtlebot3_world"])
def test_every_cell_is_as_far_from_obstacles_as_it_says(name):
    """A free cell's centre is outside of everything; an occupied one is within half a diagonal."""
    place = load_world(name)
    drawn = rasterise(place)
    still = [obstacle for obstacle in place.obstacles if obstacle.motion is None]
    for (row, column), cell in np.ndenumerate(drawn.cells):
        x = drawn.origin[0] + (column + 0.5) * drawn.resolution
        y = drawn.origin[1] + (row + 0.5) * drawn.resolution
        nearest = min(obstacle.distance(x, y) for obstacle in still)
        if cell == OCCUPIED:
            assert nearest < 0.0354
        else:
            assert nearest > 0.025 - 2e-6
