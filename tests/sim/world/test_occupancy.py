"""The map of a world, cell by cell."""

import numpy as np
import pytest

from sim.world.loader import load_world
from sim.world.occupancy import OCCUPIED, rasterise
from sim.world.world import World


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


def test_a_shape_that_ends_at_a_cells_edge_does_not_fill_the_next():
    """A box on the grid covers its own cells alone."""
    box = {"x": 0.0, "y": 0.0, "size": [0.2, 0.1, 0.1]}
    assert occupied(world(boxes=[box])) == {(2, 4), (2, 5)}


def test_a_wall_thinner_than_a_cell_is_drawn():
    """3 mm are enough to stop a robot, so they are on the map."""
    wall = {"from": [-0.3, 0.02], "to": [0.28, 0.02], "thickness": 0.003}
    assert occupied(world(walls=[wall])) == {(2, column) for column in range(2, 8)}


def test_a_slanting_wall_touches_just_the_cells_it_crosses():
    """A diagonal from cell to cell, without the corners beside it."""
    wall = {"from": [-0.14, -0.17], "to": [0.07, 0.04], "thickness": 0.002}
    assert occupied(world(walls=[wall])) == {(0, 3), (1, 3), (1, 4), (2, 4), (2, 5)}


def test_a_cylinder_fills_the_cells_its_circle_reaches_into():
    """The corner cells of its square are free where the circle misses them."""
    pillar = {"x": 0.05, "y": 0.0, "radius": 0.12}
    assert occupied(world(cylinders=[pillar])) == {
        (row, column) for row in range(1, 4) for column in range(4, 7)
    }
    small = {"x": 0.05, "y": 0.0, "radius": 0.06}
    assert occupied(world(cylinders=[small])) == {(1, 5), (3, 5), (2, 4), (2, 5), (2, 6)}


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
