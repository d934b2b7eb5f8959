import math

import numpy as np
import pytest

from action_servers.core.grid import survey
from action_servers.core.maneuver import Grid
from action_servers.mapping.frontiers import choose, edge_cells, frontiers
from action_servers.navigation.path import cost_model
from action_servers.navigation.planner import road_map
from bt_mission.base.geometry import Pose2D

CELLS = 4
EDGE_M = 0.2

ROOM = """
    ####################
    #..................#
    #..................#
    #..................#
    #..................???
    #..................???
    #..................#
    #..................#
    #..................#
    ####################
"""


def drawn(text):
    """A map from text: `#` occupied, `.` free, `?` and what is missing at the end unknown."""
    lines = [line.strip() for line in text.strip().splitlines()][::-1]
    width = max(map(len, lines))
    values = {"#": 100, ".": 0, "?": -1}
    coarse = np.array([[values[c] for c in line.ljust(width, "?")] for line in lines])
    fine = np.kron(coarse, np.ones((CELLS, CELLS))).astype(np.int8)
    return Grid(EDGE_M / CELLS, 0.0, 0.0, fine)


def best(grid, waffle, pose, shortest=0.3):
    """The choice of a Waffle at a pose, and what it cannot get to."""
    roads = road_map(survey(grid), cost_model(waffle.turning_radius))
    return choose(frontiers(grid, shortest), roads, pose)


def test_a_room_with_closed_walls_has_no_edge():
    """Free cells beside walls are no frontier, although the unknown begins behind them."""
    assert not edge_cells(drawn("####\n#..#\n#..#\n####")).any()


def test_the_edge_is_free_and_beside_the_unknown():
    """One column of cells in the door, two characters high, but for the seam along the wall."""
    grid = drawn(ROOM)
    rows, columns = np.nonzero(edge_cells(grid))
    assert len(rows) == 2 * CELLS - 2
    assert set(columns) == {19 * CELLS - 1}


def test_beyond_the_map_is_unknown():
    """A map that is all free has its border for an edge."""
    edges = edge_cells(drawn("...\n...\n..."))
    assert edges.sum() == 4 * 3 * CELLS - 4
    assert not edges[1:-1, 1:-1].any()


def test_no_unknown_no_frontier():
    """An empty list of an empty map, too."""
    assert frontiers(Grid(0.05, 0.0, 0.0, np.zeros((0, 0), dtype=np.int8)), 0.1) == []


def test_what_touches_is_one_frontier_and_its_length_counts():
    """Doors of 0.4 m and 0.2 m, less a cell on either side; the smaller is left out from 0.15 m."""
    grid = drawn("####\n#..?\n#..?\n#..#\n#..?\n####")
    sizes = sorted(frontier.size for frontier in frontiers(grid, 0.1))
    assert sizes == pytest.approx([0.1, 0.3])
    assert [frontier.size for frontier in frontiers(grid, 0.15)] == pytest.approx([0.3])


def test_the_middle_of_a_frontier_is_one_of_its_cells():
    """Also where it bends round a corner and the centre is beside it."""
    (frontier,) = frontiers(drawn("...\n.??\n.??"), 0.1, [(0.3, 0.6)], 0.0)[:1]
    assert min(math.dist(frontier.middle, point) for point in frontier.points) == 0.0


def test_cells_around_a_point_that_was_given_up_belong_to_none():
    """The rest of a long frontier stays, cut in two."""
    grid = drawn("??????????????\n..............\n##############")
    whole = frontiers(grid, 0.3)
    cut = frontiers(grid, 0.3, [(1.4, 0.4)], 0.35)
    assert (len(whole), len(cut)) == (1, 2)
    gaps = [math.dist((1.4, 0.4), point) for frontier in cut for point in frontier.points]
    assert min(gaps) >= 0.35


def test_the_robot_is_sent_to_the_frontier(waffle):
    """To a place near it, where it fits, with its back to where it came from."""
    target, shut_off = best(drawn(ROOM), waffle, Pose2D(1.0, 1.0, 0.0))
    assert target is not None
    assert shut_off == []
    assert math.dist((target.pose.x, target.pose.y), (3.8, 1.0)) < 0.4
    assert abs(target.pose.yaw) < 0.2


def test_a_near_frontier_is_better_than_a_far_one_and_a_long_one_than_a_short_one(waffle):
    """Two doors in a corridor: the price is way and turning, less what length is worth."""
    grid = drawn(
        """
        #####??########??????###
        #......................#
        #......................#
        #......................#
        #......................#
        ########################
        """
    )
    left, _ = best(grid, waffle, Pose2D(1.0, 0.6, math.pi / 2))
    middle, _ = best(grid, waffle, Pose2D(2.4, 0.6, math.pi / 2))
    assert left is not None
    assert middle is not None
    assert left.frontier.size == pytest.approx(0.3)
    assert middle.frontier.size == pytest.approx(1.1)


def test_a_frontier_behind_a_gap_too_narrow_for_the_robot_is_shut_off(waffle):
    """A Waffle needs 0.5 m; it is told, and no target is made of it."""
    grid = drawn(
        """
        ##################
        #......#.........?
        #......#.........?
        #......#.........?
        #......#.........?
        #................?
        #......#.........?
        #......#.........?
        #......#.........?
        ##################
        """
    )
    target, shut_off = best(grid, waffle, Pose2D(0.7, 0.9, 0.0))
    assert target is None
    assert len(shut_off) == 1


def test_a_frontier_behind_a_wall_is_not_taken_for_near(waffle):
    """A place is no view point of what a wall hides from it, however near."""
    grid = drawn(
        """
        ############
        #..........#
        #..........#
        #..........#
        #..........#
        ############
        #.????????.#
        #??????????#
        """
    )
    target, shut_off = best(grid, waffle, Pose2D(1.0, 1.0, 0.0), shortest=0.2)
    assert target is None
    assert len(shut_off) == 2


def test_a_robot_that_stands_off_the_map_has_no_choice(waffle):
    """And no error."""
    target, shut_off = best(drawn(ROOM), waffle, Pose2D(-5.0, 0.0, 0.0))
    assert target is None
    assert len(shut_off) == 1
