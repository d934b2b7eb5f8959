"""Facts about paths: searched on roads that keep room for the robot, straightened and smoothed."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from action_servers.core.grid import survey
from action_servers.core.maneuver import ErrorCode, Grid
from action_servers.navigation.path import (
    NAVIGATION,
    Path,
    cost_model,
    path_through,
    smooth,
    straighten,
)
from action_servers.navigation.planner import NoPath, plan, road_map

RADIUS = 0.2377
"""The turning circle of a Waffle."""
CELL = 0.05
COST = cost_model(0.238)
BEND = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])


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


def room_with(columns, value, rows=slice(None), gap=slice(0)):
    """A room of 3 x 3 m with a wall, or what is unknown, in some columns, and a gap in it."""
    cells = room(60, 60)
    cells[rows, columns] = value
    cells[gap, columns] = 0
    return cells


def with_gap(width):
    """The cells of a room of 3 x 2 m, and a wall across it with a gap of `width` cells."""
    return room_with(30, 100, gap=slice(20 - width // 2, 20 - width // 2 + width))[:40]


def planned(cells, start, goal):
    """The path over the roads of a map; there must be one."""
    path = plan(roads_of(cells), start, goal)
    assert isinstance(path, Path)
    return path


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
    assert planned(room(60, 60), (0.8, 0.9), (2.1, 1.6)).length == pytest.approx(np.hypot(1.3, 0.7))


def test_the_robot_takes_a_gap_in_which_it_could_turn():
    """0.55 m is wider than the turning circle of 0.475 m and its margin."""
    path = planned(with_gap(11), (0.6, 1.0), (2.4, 1.0))
    assert path.length == pytest.approx(1.8, abs=0.1)


@pytest.mark.parametrize(
    ("cells", "start", "goal", "code", "reason"),
    [
        pytest.param(
            with_gap(9),
            (0.6, 1.0),
            (2.4, 1.0),
            ErrorCode.NO_VALID_PATH,
            "no path from (0.60, 1.00) to (2.40, 1.00) keeps 0.25 m from every obstacle",
            id="a gap in which it could not turn, 0.45 m",
        ),
        pytest.param(
            with_gap(10),
            (0.6, 1.0),
            (1.52, 0.5),
            ErrorCode.GOAL_OCCUPIED,
            "the robot does not fit at the goal (1.52, 0.50): 0.00 m to the nearest obstacle, "
            "it needs 0.25 m",
            id="a goal in a wall",
        ),
        pytest.param(
            room_with(slice(20, 40), -1, slice(20, 40)),
            (0.6, 0.6),
            (1.5, 1.5),
            ErrorCode.GOAL_OCCUPIED,
            "the robot does not fit at the goal (1.50, 1.50): the map does not know that place",
            id="a goal that the map does not know",
        ),
        pytest.param(
            room(8, 8),
            (0.2, 0.2),
            (0.2, 0.2),
            ErrorCode.GOAL_OCCUPIED,
            "the robot does not fit at the goal (0.20, 0.20): ",
            id="a closet in which the robot fits nowhere",
        ),
        pytest.param(
            with_gap(10),
            (1.51, 0.5),
            (0.6, 1.0),
            ErrorCode.START_OCCUPIED,
            "the robot",
            id="a robot inside an obstacle",
        ),
        pytest.param(
            room(40, 40),
            (-0.1, 1.0),
            (1.0, 1.0),
            ErrorCode.START_OUTSIDE_MAP,
            "the robot, at (-0.10, 1.00), is outside the map",
            id="a robot outside the map",
        ),
        pytest.param(
            room(40, 40),
            (1.0, 1.0),
            (1.0, 2.1),
            ErrorCode.GOAL_OUTSIDE_MAP,
            "the goal (1.00, 2.10) is outside the map",
            id="a goal outside the map",
        ),
    ],
)
def test_where_there_is_no_path_code_and_reason_say_why(cells, start, goal, code, reason):
    """With the places, and the room that there is and that is needed."""
    none = plan(roads_of(cells), start, goal)
    assert isinstance(none, NoPath)
    assert none.code is code
    assert none.reason.startswith(reason)


def test_a_goal_close_to_a_wall_is_reached_as_far_as_the_robot_fits():
    """Within `goal_distance`, the path ends beside the goal."""
    path = planned(room(60, 60), (1.5, 1.5), (0.28, 1.5))
    beside = float(np.hypot(*(path.points[-1] - (0.28, 1.5))))
    assert 0.0 < beside <= NAVIGATION.goal_distance


def test_a_robot_that_stands_close_to_a_wall_gets_out():
    """The path begins where it stands, and leads straight to where it may be."""
    roads = roads_of(room(60, 60))
    path = plan(roads, (0.15, 1.5), (1.5, 1.5))
    assert isinstance(path, Path)
    assert path.points[0] == pytest.approx((0.15, 1.5))
    assert np.all(np.diff(roads.survey.clearance_at(path.points[:5])) > 0)


def test_a_robot_close_to_a_thin_wall_gets_out_on_its_own_side():
    """The nearest free cell behind the wall is none of its."""
    cells = room_with(30, 100, gap=slice(40, 55))
    assert planned(cells, (1.42, 0.6), (2.2, 0.6)).length > 2.5


def test_paths_keep_out_of_what_the_map_does_not_know():
    """The way round is taken though the straight line is not occupied."""
    path = planned(room_with(slice(28, 32), -1, slice(1, 40)), (0.6, 0.6), (2.4, 0.6))
    assert path.points[:, 1].max() > 2.0


def test_of_two_equal_ways_the_same_is_taken_every_time():
    """Edges are weighed in whole numbers, so equal ways are equal to the last bit."""
    cells = room(61, 61)
    cells[28:33, 28:33] = 100
    first, second = (planned(cells, (0.5, 1.525), (2.55, 1.525)) for _ in range(2))
    assert np.array_equal(first.points, second.points)


def test_paths_prefer_room_over_the_shortest_way():
    """Between two walls the robot drives in the middle, not along one of them."""
    path = planned(room(24, 100), (0.5, 0.35), (4.5, 0.35))
    assert path.at(path.length / 2)[1] > 0.42


@pytest.fixture
def pillar():
    """A room of 4 x 2.8 m with a pillar of 0.2 m in the middle."""
    cells = np.zeros((56, 80), dtype=np.int8)
    cells[:4] = cells[-4:] = 100
    cells[:, :4] = cells[:, -4:] = 100
    cells[28:32, 36:40] = 100
    return survey(Grid(CELL, 0.0, 0.0, cells))


def turns_of(path):
    """The angles between neighbouring parts of a path, rad."""
    steps = np.diff(path.points, axis=0)
    return np.abs(np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))))


def test_a_path_knows_its_length_and_its_points():
    """Length runs along the polyline, and before the start and behind the end are the ends."""
    path = path_through(BEND)
    assert path.length == 2.0
    assert path.at(1.5) == (1.0, 0.5)
    assert path.at(-1.0) == (0.0, 0.0)
    assert path.at(9.0) == (1.0, 1.0)
    assert path.end_direction() == pytest.approx(math.pi / 2)


def test_the_nearest_place_is_a_foot_on_a_segment():
    """It says how far along it is, and how far away."""
    assert path_through(BEND).nearest(0.4, 0.3, 0.0, 2.0) == pytest.approx((0.4, 0.3))


def test_the_nearest_place_is_looked_for_within_a_stretch():
    """A path that comes back to where it has been is not cut short."""
    there_and_back = path_through(np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 0.1], [0.0, 0.1]]))
    along, _ = there_and_back.nearest(0.5, 0.1, 0.4, 1.0)
    assert along == pytest.approx(0.5)


def test_steps_over_cells_become_one_line(pillar):
    """Where nothing is in the way, a staircase is a straight line in the end."""
    stairs = np.array([[0.5 + 0.05 * ((k + 1) // 2), 0.5 + 0.05 * (k // 2)] for k in range(21)])
    assert straighten(stairs, pillar, COST).tolist() == [stairs[0].tolist(), stairs[-1].tolist()]


def test_a_line_does_not_pass_closer_to_a_pillar_than_the_path_it_replaces(pillar):
    """Straightening weighs clearance as the search did."""
    around = np.array([[1.0, 1.3], [1.9, 2.0], [2.8, 1.3]])
    straight = straighten(around, pillar, COST)
    assert len(straight) == 3


def test_smoothing_keeps_both_ends_and_rounds_the_corner(pillar):
    """No turn between neighbouring points is sharp any more."""
    path = smooth(0.6 + BEND, pillar, COST)
    assert path.points[0].tolist() == [0.6, 0.6]
    assert path.points[-1].tolist() == [1.6, 1.6]
    turns = turns_of(path)
    assert turns.max() < math.radians(20)
    assert turns.sum() == pytest.approx(math.pi / 2, abs=0.05)


def test_smoothing_leaves_a_corner_sharp_that_has_no_room(pillar):
    """Clearance comes before smoothness."""
    hugging = np.array([[1.6, 1.0], [1.6, 1.8], [2.2, 1.8], [2.2, 1.0]])
    path = smooth(hugging, pillar, COST)
    assert pillar.clearance_at(path.points).min() == pytest.approx(0.2)
    assert turns_of(path).max() > math.radians(20)


def test_a_path_to_where_the_robot_stands_has_no_length(pillar):
    """Start and goal may coincide."""
    here = np.array([[0.6, 0.6], [0.6, 0.6]])
    path = smooth(straighten(here, pillar, COST), pillar, COST)
    assert path.length == 0.0
    assert path.nearest(0.7, 0.6, 0.0, 1.0) == pytest.approx((0.0, 0.1))


def test_room_costs_nothing_and_a_tight_place_five_times_as_much():
    """From comfort on a metre costs 1, from the radius down 5, and in between the more the tighter.

    A robot that starts in a tight place can still compare ways out.
    """
    assert COST.radius == pytest.approx(0.248)
    prices = COST.price(np.array([0.0, COST.radius, 0.3, 0.4, COST.comfort, 2.0]))
    assert prices[:2] == pytest.approx([5.0, 5.0])
    assert prices[4:] == pytest.approx([1.0, 1.0])
    assert np.all(np.diff(prices[1:5]) < 0)
