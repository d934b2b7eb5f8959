import numpy as np
import pytest

from action_servers.core.maneuver import Grid
from action_servers.mapping.node import VisitedArea
from bt_mission.base.geometry import Pose2D


def grid_of(cells, x=0.0, y=0.0):
    """A map of cells of 0.05 m whose corner is at x, y."""
    return Grid(0.05, x, y, np.asarray(cells, dtype=np.int8))


def test_free_and_occupied_cells_are_known():
    """Three of four cells of 0.0025 m²."""
    measure = VisitedArea().measure(grid_of([[0, 100], [-1, 0]]))
    assert measure.area == pytest.approx(3 * 0.0025)
    assert measure.fraction == pytest.approx(0.75)


def test_an_empty_map_has_no_area():
    """And no share of nothing."""
    measure = VisitedArea().measure(grid_of(np.zeros((0, 0))))
    assert (measure.area, measure.fraction, measure.zones) == (0.0, 0.0, 0)


def test_a_zone_counts_when_the_middle_of_the_axle_has_been_in_it():
    """Zones begin at whole metres, also below zero; the same one counts once."""
    coverage = VisitedArea()
    for x, y in ((0.1, 0.1), (0.9, 0.9), (1.1, 0.1), (-0.1, 0.1)):
        coverage.visit(Pose2D(x, y, 0.0))
    assert coverage.measure(grid_of([[-1]])).zones_visited == 3


def test_a_robot_on_a_corner_of_four_zones_has_visited_none():
    """It must come 0.05 m into one."""
    coverage = VisitedArea()
    for x, y in ((0.0, 0.0), (-1e-6, 1e-6), (0.04, 0.5), (0.5, 0.96)):
        coverage.visit(Pose2D(x, y, 0.0))
    assert coverage.measure(grid_of([[-1]])).zones_visited == 0


def test_zones_are_those_half_free_and_those_visited():
    """Two squares of a metre, one all free and one free by a little less than half."""
    cells = np.full((20, 40), -1)
    cells[:, :20] = 0
    cells[:, 20:30] = 0
    cells[0, 29] = 100
    coverage = VisitedArea()
    assert coverage.measure(grid_of(cells, -1.0, 3.0)).zones == 1
    coverage.visit(Pose2D(0.5, 3.5, 0.0))
    measure = coverage.measure(grid_of(cells, -1.0, 3.0))
    assert (measure.zones_visited, measure.zones) == (1, 2)
