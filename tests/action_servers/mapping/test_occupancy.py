import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from action_servers.core.maneuver import Scan
from action_servers.mapping.occupancy import FREE, OCCUPIED, UNKNOWN, OccupancyMapper
from bt_mission.base.geometry import Pose2D
from bt_mission.robots.model import load_robot

LIDAR = load_robot("waffle").lidar
AT_ORIGIN = Pose2D(-LIDAR.x, -LIDAR.y, 0.0)
"""The pose of the base that puts the lidar at the origin."""


def mapped(make_scan, ranges, *, times=2, pose=AT_ORIGIN, **options):
    """The map after some equal scans."""
    mapper = OccupancyMapper(LIDAR)
    for _ in range(times):
        assert mapper.add(make_scan(ranges, **options), pose)
    return mapper.grid()


def cell(grid, x, y):
    """The value of the cell at a point."""
    row = math.floor((y - grid.origin_y) / grid.resolution)
    column = math.floor((x - grid.origin_x) / grid.resolution)
    return grid.cells[row, column]


def square(half, rays=360):
    """Ranges to the walls of a square room around the lidar."""
    angles = np.arange(rays) * math.tau / rays
    return half / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))


def test_there_is_nothing_before_the_first_scan():
    """No cell, and it says so."""
    mapper = OccupancyMapper(LIDAR)
    assert mapper.empty
    assert mapper.grid().cells.size == 0


def test_a_room_is_free_inside_walled_and_unknown_outside(make_scan):
    """The square that the rays fill, its edge, and nothing beyond."""
    grid = mapped(make_scan, square(1.51))
    for x, y in ((0.0, 0.0), (1.3, 0.0), (-1.3, 1.3), (0.7, -1.4)):
        assert cell(grid, x, y) == FREE
    for x, y in ((1.52, 0.0), (-1.52, 0.3), (0.5, 1.52), (-0.2, -1.52)):
        assert cell(grid, x, y) == OCCUPIED
    assert cell(grid, 1.7, 0.0) == UNKNOWN


def test_no_cell_between_rays_is_left_out(make_scan):
    """At 3 m rays are 0.052 m apart, wider than a cell; all cells before the wall are free."""
    grid = mapped(make_scan, np.full(360, 3.0))
    rows, columns = np.indices(grid.cells.shape)
    x = grid.origin_x + (columns + 0.5) * grid.resolution
    y = grid.origin_y + (rows + 0.5) * grid.resolution
    assert np.all(grid.cells[np.hypot(x, y) < 2.9] == FREE)


def test_two_rays_make_a_cell_free_and_one_makes_it_an_obstacle(make_scan):
    """An obstacle is believed at once, free space when it is seen again."""
    once = mapped(make_scan, square(1.51), times=1)
    assert cell(once, 0.5, 0.5) == UNKNOWN
    assert cell(once, 1.52, 0.0) == OCCUPIED


def test_a_ray_of_inf_clears_as_far_as_the_lidar_reaches(make_scan):
    """Nothing is there, and no obstacle at its end; also when the message names a longer range."""
    for range_max in (3.5, 100.0):
        grid = mapped(make_scan, np.full(360, np.inf), range_max=range_max)
        assert cell(grid, 3.4, 0.0) == FREE
        assert not (grid.cells == OCCUPIED).any()
        assert grid.cells.shape[0] * grid.resolution <= 8.0


@pytest.mark.parametrize("nothing", [math.nan, 0.0, -1.0, -math.inf, 0.05, 3.6])
def test_a_ray_that_tells_nothing_changes_nothing(make_scan, nothing):
    """NaN, 0.0, negative values, and what is nearer or farther than the lidar can see."""
    ranges = square(1.51)
    ranges[:90] = nothing
    grid = mapped(make_scan, ranges)
    assert cell(grid, 0.7, 0.7) == UNKNOWN
    assert cell(grid, -0.7, 0.7) == FREE
    assert mapped(make_scan, np.full(360, nothing)).cells.size == 0


def test_a_scan_is_placed_by_its_pose(make_scan):
    """Turned by 90 degrees, what is ahead is to the left of the map's x."""
    ranges = np.full(360, np.nan)
    ranges[-5:] = ranges[:6] = 1.0
    turned = Pose2D(1.0, 2.0 - LIDAR.x, math.pi / 2)
    grid = mapped(make_scan, ranges, pose=turned)
    assert cell(grid, 1.0, 3.01) == OCCUPIED
    assert cell(grid, 1.0, 2.5) == FREE


def test_a_scan_that_turns_right_is_the_mirror_of_one_that_turns_left(make_scan):
    """Rays are counted the other way round where the increment is negative."""
    ranges = square(1.51).astype(np.float32)
    ranges[20:120] = 0.8
    left = make_scan(ranges)
    right = Scan(10.0, 0.0, -left.angle_increment, 0.12, 3.5, ranges[-np.arange(360) % 360])
    grids = []
    for scan in (left, right):
        mapper = OccupancyMapper(LIDAR)
        mapper.add(scan, AT_ORIGIN)
        mapper.add(scan, AT_ORIGIN)
        grids.append(mapper.grid().cells)
    assert np.array_equal(grids[0], grids[1])


def test_a_scan_of_a_part_of_the_turn_tells_of_that_part_only():
    """What is behind a lidar that looks ahead stays unknown."""
    scan = Scan(10.0, -0.5, 0.01, 0.12, 3.5, np.full(101, 2.0, dtype=np.float32))
    mapper = OccupancyMapper(LIDAR)
    for _ in range(2):
        mapper.add(scan, Pose2D(0.5 - LIDAR.x, 0.0, 0.0))
    grid = mapper.grid()
    assert grid.origin_x == 0.0
    assert cell(grid, 1.5, 0.0) == FREE
    assert np.all(grid.cells[:, :9] == UNKNOWN)


def test_what_has_left_is_forgotten_and_what_has_come_is_seen(make_scan):
    """An obstacle seen a hundred times is free after ten scans through it, and back after eight."""
    mapper = OccupancyMapper(LIDAR)
    near, far = make_scan(np.full(360, 1.0)), make_scan(np.full(360, 2.0))
    for _ in range(100):
        mapper.add(near, AT_ORIGIN)
    for _ in range(10):
        mapper.add(far, AT_ORIGIN)
    assert cell(mapper.grid(), 1.01, 0.0) == FREE
    for _ in range(8):
        mapper.add(near, AT_ORIGIN)
    assert cell(mapper.grid(), 1.01, 0.0) == OCCUPIED


def test_noise_does_not_thicken_a_wall(make_scan):
    """A wall at the edge of a cell, with noise of 0.01 m: the cell before it stays free."""
    rng = np.random.default_rng(1)
    mapper = OccupancyMapper(LIDAR)
    for _ in range(40):
        mapper.add(make_scan(square(1.5) + rng.normal(0.0, 0.01, 360)), AT_ORIGIN)
    grid = mapper.grid()
    assert cell(grid, 1.475, 0.0) == FREE
    assert cell(grid, 1.525, 0.0) == OCCUPIED


def test_the_map_grows_in_whole_metres_and_keeps_what_it_has(make_scan):
    """Bounds are multiples of a metre; the room that was mapped first is still there."""
    mapper = OccupancyMapper(LIDAR)
    for x in (0.0, 0.0, 5.0, 5.0, -7.0, -7.0):
        mapper.add(make_scan(square(1.51)), Pose2D(x - LIDAR.x, 0.0, 0.0))
    grid = mapper.grid()
    assert (grid.origin_x, grid.origin_y) == (-9.0, -2.0)
    assert grid.cells.shape == (80, 320)
    assert [cell(grid, x, 0.0) for x in (-7.0, 0.0, 5.0)] == [FREE] * 3


def test_a_pose_that_jumps_far_away_is_refused(make_scan):
    """The map stays as it was: 100 m are the most, and the memory of a robot is not endless."""
    mapper = OccupancyMapper(LIDAR)
    mapper.add(make_scan(square(1.51)), AT_ORIGIN)
    before = mapper.grid().cells
    assert not mapper.add(make_scan(square(1.51)), Pose2D(1e6, 0.0, 0.0))
    assert np.array_equal(mapper.grid().cells, before)


@settings(max_examples=60)
@given(
    ranges=st.lists(
        st.one_of(st.floats(0.0, 5.0, width=32), st.sampled_from([math.inf, math.nan, -1.0])),
        min_size=1,
        max_size=40,
    ),
    x=st.floats(-3, 3),
    yaw=st.floats(-10, 10),
    increment=st.floats(-0.5, 0.5, width=32),
)
@example(ranges=[1.0, 2.0], x=0.0, yaw=0.0, increment=1e-45)
@example(ranges=[1.0, 2.0], x=0.0, yaw=0.0, increment=0.0)
def test_any_scan_from_anywhere_leaves_a_sound_map(ranges, x, yaw, increment):
    """Whatever a driver sends: three kinds of cells, and bounds around them."""
    mapper = OccupancyMapper(LIDAR)
    scan = Scan(1.0, 0.0, increment, 0.12, 3.5, np.array(ranges, dtype=np.float32))
    assert mapper.add(scan, Pose2D(x, 0.0, yaw))
    assert set(np.unique(mapper.grid().cells)) <= {FREE, OCCUPIED, UNKNOWN}
