import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from action_servers.core.grid import centres, survey
from action_servers.core.maneuver import Grid

RESOLUTION = 0.05
ORIGIN = (-0.2, 0.1)

masks = arrays.arrays(np.bool_, st.tuples(st.integers(1, 9), st.integers(1, 9)))


def grid_of(mask):
    """A map whose occupied cells are those of a mask."""
    return Grid(RESOLUTION, *ORIGIN, np.where(mask, 100, 0).astype(np.int8))


def gaps_to_squares(mask, points):
    """The distance of each point to the nearest occupied square, computed one by one."""
    rows, columns = np.nonzero(mask)
    low_x, low_y = ORIGIN[0] + columns * RESOLUTION, ORIGIN[1] + rows * RESOLUTION
    across = np.maximum(low_x - points[:, :1], points[:, :1] - low_x - RESOLUTION).clip(0)
    along = np.maximum(low_y - points[:, 1:], points[:, 1:] - low_y - RESOLUTION).clip(0)
    return np.hypot(across, along).min(axis=1)


@given(masks)
def test_clearance_at_a_cell_is_the_distance_to_the_nearest_occupied_square(mask):
    """At centres it is exact, whatever the obstacles look like."""
    measured = survey(grid_of(mask))
    rows, columns = np.indices(mask.shape)
    middles = centres(measured, rows.ravel(), columns.ravel())
    expected = gaps_to_squares(mask, middles) if mask.any() else np.full(mask.size, 1000.0)
    assert measured.centre_clearance.ravel() == pytest.approx(expected)


@given(masks, st.floats(0, 1), st.floats(0, 1))
def test_clearance_between_cells_is_never_over_by_more_than_its_bound(mask, right, up):
    """Interpolation errs by at most resolution² / (32 clearance) towards the dangerous side."""
    measured = survey(grid_of(mask))
    rows, columns = mask.shape
    point = np.array([[-0.2 + right * columns * RESOLUTION, 0.1 + up * rows * RESOLUTION]])
    if mask.any():
        truth = float(gaps_to_squares(mask, point)[0])
        bound = RESOLUTION**2 / (32 * max(truth - 0.5 * RESOLUTION, 0.02))
        assert measured.clearance_at(point)[0] <= truth + bound + 1e-9


@given(masks, st.floats(-0.3, 0.4), st.floats(0.0, 0.7))
def test_the_clearance_of_one_point_is_that_of_many(mask, x, y):
    """The fast form for one point agrees with the other, on the grid and off it."""
    measured = survey(grid_of(mask))
    assert measured.clearance_of(x, y) == pytest.approx(
        measured.clearance_at(np.array([[x, y]]))[0]
    )


def test_off_the_grid_there_is_no_room():
    """A path cannot leave the map."""
    empty = survey(grid_of(np.zeros((4, 4), dtype=bool)))
    assert empty.clearance_of(-0.21, 0.15) == 0.0
    assert empty.clearance_at(np.array([[0.0, 0.31]]))[0] == 0.0


def test_65_and_more_is_occupied_and_less_is_free():
    """The threshold of Nav2's map server."""
    cells = np.array([[0, 64, 65, 100, -1]], dtype=np.int8)
    measured = survey(Grid(RESOLUTION, 0.0, 0.0, cells))
    assert measured.occupied.tolist() == [[False, False, True, True, False]]


def test_an_unknown_cell_is_no_obstacle_but_is_not_known():
    """It pushes nobody away; planners keep out of it."""
    measured = survey(Grid(RESOLUTION, 0.0, 0.0, np.array([[0, -1]], dtype=np.int8)))
    assert measured.known.tolist() == [[True, False]]
    assert measured.clearance_of(0.075, 0.025) == 1000.0


@pytest.mark.thorough
@given(masks, st.randoms())
def test_marks_count_as_if_they_were_on_the_map(mask, random):
    """A survey with marks equals the survey of a map that has them."""
    marks = np.array([random.random() < 0.2 for _ in range(mask.size)]).reshape(mask.shape)
    both = survey(grid_of(mask | marks))
    assert survey(grid_of(mask)).with_obstacles(marks).clearance == pytest.approx(both.clearance)


def test_a_survey_without_marks_stays_the_same_object():
    """So that nothing is computed anew."""
    measured = survey(grid_of(np.eye(3, dtype=bool)))
    assert measured.with_obstacles(np.zeros((3, 3), dtype=bool)) is measured


def test_known_ground_ends_with_the_map():
    """A point in an unknown cell is not known, nor is one off the grid."""
    measured = survey(Grid(RESOLUTION, 0.0, 0.0, np.array([[0, -1]], dtype=np.int8)))
    points = np.array([[0.02, 0.02], [0.07, 0.02], [-0.01, 0.02], [0.02, 0.06]])
    assert measured.known_at(points).tolist() == [True, False, False, False]


def test_cells_and_centres_belong_together():
    """Rows go along y, columns along x, from the origin."""
    measured = survey(grid_of(np.zeros((3, 5), dtype=bool)))
    assert measured.cell(-0.19, 0.24) == (2, 0)
    assert measured.contains(0.049, 0.249)
    assert not measured.contains(0.051, 0.2)
    assert not measured.contains(1e308, 0.2)
    assert not measured.contains(0.049, -1e308)
    rows, columns = measured.cells(centres(measured, np.array([2]), np.array([4])))
    assert (rows.tolist(), columns.tolist()) == ([2], [4])
