import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from action_servers.core.error_codes import ErrorCode
from action_servers.core.grid import survey
from action_servers.core.maneuver import Grid
from action_servers.core.tuning import NAVIGATION
from action_servers.navigation.path import Path, cost_model
from action_servers.navigation.planner import NoPath, plan, road_map

RADIUS = 0.2377
"""The turning circle of a Waffle."""
CELL = 0.05


def roads_of(cells):
    """The roads of a Waffle on a map, given as rows of cells."""
    return road_map(
        survey(Grid(CELL, 0.0, 0.0, np.asarray(cells, dtype=np.int8))), cost_model(RADIUS)
    )


def room(rows, columns):
    """A room with a wall of one cell around it."""
    cells = np.zeros((rows, columns), dtype=np.int8)
    cells[[0, -1], :] = 100
    cells[:, [0, -1]] = 100
    return cells


def with_gap(width):
    """A room of 3 x 2 m, and a wall across it with a gap of `width` cells in the middle."""
    cells = room(40, 60)
    cells[:, 30] = 100
    cells[20 - width // 2 : 20 - width // 2 + width, 30] = 0
    return roads_of(cells)


def gaps_to_squares(cells, points):
    """The distance of each point to the nearest occupied square, computed one by one."""
    rows, columns = np.nonzero(cells == 100)
    across = np.maximum(columns * CELL - points[:, :1], points[:, :1] - (columns + 1) * CELL).clip(
        0
    )
    along = np.maximum(rows * CELL - points[:, 1:], points[:, 1:] - (rows + 1) * CELL).clip(0)
    return np.hypot(across, along).min(axis=1)


@st.composite
def cluttered_rooms(draw):
    """Rooms of 2 x 2 m with up to five walls and pillars in them."""
    cells = room(40, 40)
    for _ in range(draw(st.integers(0, 5))):
        row, column = draw(st.integers(1, 36)), draw(st.integers(1, 36))
        height, width = draw(st.sampled_from([(1, 12), (12, 1), (3, 3)]))
        cells[row : row + height, column : column + width] = 100
    return cells


@settings(max_examples=60, deadline=None)
@given(cluttered_rooms(), st.integers(0, 10_000), st.integers(0, 10_000))
def test_every_path_keeps_the_robots_radius_from_every_obstacle(cells, first, last):
    """Measured against the squares themselves, every 5 mm along the path."""
    roads = roads_of(cells)
    if len(roads.centres):
        x, y = roads.centres[first % len(roads.centres)].tolist()
        goal_x, goal_y = roads.centres[last % len(roads.centres)].tolist()
        start, goal = (x, y), (goal_x, goal_y)
        path = plan(roads, start, goal)
        if isinstance(path, Path):
            along = np.arange(0.0, path.length, 0.005)
            points = np.array([path.at(distance) for distance in along] or [start])
            assert gaps_to_squares(cells, points).min() >= RADIUS
            assert path.points[0] == pytest.approx(start)
            assert path.points[-1] == pytest.approx(goal)
        else:
            assert path.code is ErrorCode.NO_VALID_PATH


def test_a_path_across_an_empty_room_is_straight():
    """Not a staircase of cells."""
    path = plan(roads_of(room(60, 60)), (0.8, 0.9), (2.1, 1.6))
    assert isinstance(path, Path)
    assert path.length == pytest.approx(np.hypot(1.3, 0.7))


def test_the_robot_takes_a_gap_in_which_it_could_turn():
    """0.55 m is wider than the turning circle of 0.475 m and its margin."""
    path = plan(with_gap(11), (0.6, 1.0), (2.4, 1.0))
    assert isinstance(path, Path)
    assert path.length == pytest.approx(1.8, abs=0.1)


def test_the_robot_does_not_take_a_gap_in_which_it_could_not_turn():
    """0.45 m would let its hull of 0.306 m through, but not let it change its mind there."""
    assert plan(with_gap(9), (0.6, 1.0), (2.4, 1.0)) == NoPath(
        ErrorCode.NO_VALID_PATH,
        "no path from (0.60, 1.00) to (2.40, 1.00) keeps 0.25 m from every obstacle",
    )


def test_a_goal_in_a_wall_is_occupied():
    """The reason tells how much room there is and how much is needed."""
    assert plan(with_gap(10), (0.6, 1.0), (1.52, 0.5)) == NoPath(
        ErrorCode.GOAL_OCCUPIED,
        "the robot does not fit at the goal (1.52, 0.50): 0.00 m to the nearest obstacle, "
        "it needs 0.25 m",
    )


def test_a_goal_close_to_a_wall_is_reached_as_far_as_the_robot_fits():
    """Within `goal_distance`, the path ends beside the goal."""
    path = plan(roads_of(room(60, 60)), (1.5, 1.5), (0.28, 1.5))
    assert isinstance(path, Path)
    beside = float(np.hypot(*(path.points[-1] - (0.28, 1.5))))
    assert 0.0 < beside <= NAVIGATION.goal_distance


def test_outside_the_map_has_codes_of_its_own():
    """For the robot, and for the goal."""
    roads = roads_of(room(40, 40))
    assert plan(roads, (-0.1, 1.0), (1.0, 1.0)) == NoPath(
        ErrorCode.START_OUTSIDE_MAP, "the robot, at (-0.10, 1.00), is outside the map"
    )
    assert plan(roads, (1.0, 1.0), (1.0, 2.1)) == NoPath(
        ErrorCode.GOAL_OUTSIDE_MAP, "the goal (1.00, 2.10) is outside the map"
    )


def test_a_robot_that_stands_close_to_a_wall_gets_out():
    """The path begins where it stands, and leads straight to where it may be."""
    roads = roads_of(room(60, 60))
    path = plan(roads, (0.15, 1.5), (1.5, 1.5))
    assert isinstance(path, Path)
    assert path.points[0] == pytest.approx((0.15, 1.5))
    assert np.all(np.diff(roads.survey.clearance_at(path.points[:5])) > 0)


def test_a_robot_close_to_a_thin_wall_gets_out_on_its_own_side():
    """The nearest free cell behind the wall is none of its."""
    cells = room(60, 60)
    cells[:, 30] = 100
    cells[40:55, 30] = 0
    path = plan(roads_of(cells), (1.42, 0.6), (2.2, 0.6))
    assert isinstance(path, Path)
    assert path.length > 2.5


def test_a_robot_inside_an_obstacle_is_stuck():
    """Its pose or the map is wrong, and no path would be safe."""
    stuck = plan(with_gap(10), (1.51, 0.5), (0.6, 1.0))
    assert isinstance(stuck, NoPath)
    assert stuck.code is ErrorCode.START_OCCUPIED


def test_paths_keep_out_of_what_the_map_does_not_know():
    """The way round is taken though the straight line is not occupied."""
    cells = room(60, 60)
    cells[1:40, 28:32] = -1
    path = plan(roads_of(cells), (0.6, 0.6), (2.4, 0.6))
    assert isinstance(path, Path)
    assert path.points[:, 1].max() > 2.0


def test_a_goal_that_the_map_does_not_know_is_refused_with_that_reason():
    """There is room for all one knows, but nobody has looked."""
    cells = room(60, 60)
    cells[20:40, 20:40] = -1
    assert plan(roads_of(cells), (0.6, 0.6), (1.5, 1.5)) == NoPath(
        ErrorCode.GOAL_OCCUPIED,
        "the robot does not fit at the goal (1.50, 1.50): the map does not know that place",
    )


def test_a_map_without_a_free_cell_has_no_goals():
    """A closet in which the robot fits nowhere."""
    nowhere = plan(roads_of(room(8, 8)), (0.2, 0.2), (0.2, 0.2))
    assert isinstance(nowhere, NoPath)
    assert nowhere.code is ErrorCode.GOAL_OCCUPIED


def test_of_two_equal_ways_the_same_is_taken_every_time():
    """Edges are weighed in whole numbers, so equal ways are equal to the last bit."""
    cells = room(61, 61)
    cells[28:33, 28:33] = 100
    first, second = (plan(roads_of(cells), (0.5, 1.525), (2.55, 1.525)) for _ in range(2))
    assert isinstance(first, Path)
    assert isinstance(second, Path)
    assert np.array_equal(first.points, second.points)


def test_paths_prefer_room_over_the_shortest_way():
    """Between two walls the robot drives in the middle, not along one of them."""
    cells = room(24, 100)
    path = plan(roads_of(cells), (0.5, 0.35), (4.5, 0.35))
    assert isinstance(path, Path)
    assert path.at(path.length / 2)[1] > 0.42
