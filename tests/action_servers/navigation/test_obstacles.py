import math

import numpy as np
import pytest

from action_servers.core.grid import survey
from action_servers.core.maneuver import Grid, Scan
from action_servers.core.tuning import NAVIGATION
from action_servers.navigation.obstacles import ObstacleLayer
from bt_mission.core.geometry import Pose2D

LIDAR = Pose2D(2.02, 2.02, 0.0)
RAYS = 360


@pytest.fixture
def room():
    """An empty room of 4 x 4 m with walls of one cell."""
    cells = np.zeros((80, 80), dtype=np.int8)
    cells[[0, -1], :] = 100
    cells[:, [0, -1]] = 100
    return survey(Grid(0.05, 0.0, 0.0, cells))


def scan_of(ranges, stamp_s=1.0, increment=math.tau / RAYS, first=0.0):
    """A scan from bearings in degrees to ranges in metres; the others see nothing."""
    all_ranges = np.full(RAYS, np.inf, dtype=np.float32)
    for bearing, value in ranges.items():
        all_ranges[bearing % RAYS] = value
    return Scan(stamp_s, first, increment, 0.12, 3.5, all_ranges)


def points_of(scan):
    """Where its rays end, in the map frame."""
    angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    hit = np.isfinite(scan.ranges) & (scan.ranges > 0)
    ranges = scan.ranges[hit].astype(float)
    return np.column_stack(
        (LIDAR.x + ranges * np.cos(angles[hit]), LIDAR.y + ranges * np.sin(angles[hit]))
    )


def look(layer, scan):
    """Show a scan to a layer."""
    return layer.update(scan, points_of(scan), LIDAR)


def marked(layer):
    """Rows and columns of the marks."""
    return [tuple(map(int, cell)) for cell in np.argwhere(layer.marks)]


def test_what_the_map_does_not_have_is_marked(room):
    """A point 1 m ahead lies in column (2.02 + 1.01) / 0.05."""
    layer = ObstacleLayer(room)
    assert look(layer, scan_of({0: 1.01})) is True
    assert marked(layer) == [(40, 60)]


def test_what_the_map_has_is_not_marked_though_it_is_seen_with_noise(room):
    """A wall 1.93 m away, seen 3 cm too near, is still the wall."""
    layer = ObstacleLayer(room)
    assert look(layer, scan_of({0: 1.90})) is False
    assert marked(layer) == []


def test_a_mark_that_is_seen_again_changes_nothing(room):
    """So that no clearance is computed anew."""
    layer = ObstacleLayer(room)
    look(layer, scan_of({0: 1.01}))
    assert look(layer, scan_of({0: 1.01}, 1.1)) is False


def test_a_mark_goes_when_rays_pass_through_it(room):
    """Who stepped aside is no obstacle any more."""
    layer = ObstacleLayer(room)
    look(layer, scan_of({0: 1.01}))
    assert look(layer, scan_of(dict.fromkeys((-1, 0, 1), 1.95), 1.1)) is True
    assert marked(layer) == []


def test_a_mark_goes_when_its_rays_meet_nothing_at_all(room):
    """Inf means that nothing is within range (REP 117)."""
    layer = ObstacleLayer(room)
    look(layer, scan_of({0: 1.01}))
    look(layer, scan_of({}, 1.1))
    assert marked(layer) == []


def test_a_mark_stays_when_one_of_its_rays_does_not_pass(room):
    """A thin leg may be missed by two rays of three."""
    layer = ObstacleLayer(room)
    look(layer, scan_of({0: 1.01}))
    look(layer, scan_of({-1: 1.95, 0: 1.95, 1: 0.8}, 1.1))
    assert (40, 60) in marked(layer)


@pytest.mark.parametrize("nothing", [np.nan, 0.0])
def test_a_mark_stays_when_its_rays_measured_nothing(room, nothing):
    """NaN and 0 say that the lidar does not know."""
    layer = ObstacleLayer(room)
    look(layer, scan_of({0: 1.01}))
    look(layer, scan_of(dict.fromkeys((-1, 0, 1), nothing), 1.1))
    assert marked(layer) == [(40, 60)]


def test_a_mark_behind_something_stays_until_it_is_forgotten(room):
    """Out of sight it is believed for `obstacle_memory`, and not longer."""
    layer = ObstacleLayer(room)
    look(layer, scan_of({0: 1.51}))
    hidden = dict.fromkeys((-1, 0, 1), 0.8)
    look(layer, scan_of(hidden, 1.0 + NAVIGATION.obstacle_memory))
    assert (40, 70) in marked(layer)
    look(layer, scan_of(hidden, 1.1 + NAVIGATION.obstacle_memory))
    assert (40, 70) not in marked(layer)


def test_a_lidar_that_turns_to_the_right_clears_the_same_marks(room):
    """Its rays count clockwise."""
    layer = ObstacleLayer(room)
    look(layer, scan_of({-90: 1.01}))
    assert marked(layer) == [(20, 40)]
    look(layer, scan_of(dict.fromkeys((89, 90, 91), 1.9), 1.1, increment=-math.tau / RAYS))
    assert marked(layer) == []


def test_a_lidar_that_looks_only_ahead_clears_nothing_behind(room):
    """A mark outside its field of view is not seen through."""
    layer = ObstacleLayer(room)
    look(layer, scan_of({180: 1.01}))
    half = np.full(180, np.inf, dtype=np.float32)
    look(layer, Scan(1.1, -math.pi / 2, math.pi / 180, 0.12, 3.5, half))
    assert marked(layer) == [(40, 20)]


def test_marks_stay_where_they_are_when_the_map_grows(room):
    """They move to the cells of the new map, but those that it has itself."""
    layer = ObstacleLayer(room)
    look(layer, scan_of({0: 1.01, 90: 1.01}))
    cells = np.zeros((90, 90), dtype=np.int8)
    cells[70, 50] = 100
    wider = layer.over(survey(Grid(0.05, -0.5, -0.5, cells)))
    assert marked(wider) == [(50, 70)]
