"""Facts about the map with what the lidar adds, and the poses by which scans are placed."""

import dataclasses
import math

import numpy as np
import pytest

from action_servers.core.grid import survey
from action_servers.core.maneuver import Grid, Scan
from action_servers.navigation.path import NAVIGATION
from action_servers.navigation.pose_history import PoseHistory
from action_servers.navigation.surroundings import ObstacleLayer, Surroundings
from bt_mission.base.geometry import Pose2D

ROOM = """
    ###############
    #.............#
    #.............#
    #.............#
    #.............#
    #..R.....o....#
    #.............#
    #.............#
    #.............#
    #.............#
    ###############
"""


@pytest.fixture
def robot(world, robot_in):
    """A Waffle in a room with an obstacle that the map does not have."""
    return robot_in(world(ROOM))


@pytest.fixture
def around(waffle) -> Surroundings:
    """The surroundings of a Waffle that has seen nothing."""
    return Surroundings(waffle)


@pytest.fixture
def now(robot, around):
    """What the robot has seen at once, which its surroundings know."""
    seen = robot.observe()
    around.observe(seen)
    return seen


def test_nothing_is_known_before_map_and_scan(around, robot):
    """A scan without a pose cannot be placed."""
    now = robot.observe()
    ready = []
    for pose in (None, robot.pose):
        around.observe(dataclasses.replace(now, map_pose=pose))
        ready.append(around.ready)
    assert ready == [False, True]
    assert around.seen_s == 10.0


def test_the_survey_has_what_the_lidar_adds_and_the_map_has_not(around, now):
    """The obstacle is in the one, not in the other; forgetting leaves the map."""
    edge = (9 * 0.2 - 0.01, 5.5 * 0.2)
    assert around.mapped.clearance_of(*edge) > 0.5
    assert around.survey.clearance_of(*edge) < 0.05
    around.forget()
    assert around.survey is around.mapped
    assert around.seen_s == 10.0


@pytest.mark.parametrize(
    ("yaw", "poses"),
    [(0.0, [(10.0, 0.0), (10.1, 1.0)]), (0.3, [(9.95, 0.2), (10.05, 0.4)])],
    ids=["at a pose", "half way between two"],
)
def test_a_scan_is_placed_where_the_robot_was_when_it_was_taken(waffle, around, robot, yaw, poses):
    """A robot that has turned since sees no obstacle in a new direction."""
    robot.pose = dataclasses.replace(robot.pose, yaw=yaw)
    now = robot.observe()
    exact = Surroundings(waffle)
    exact.observe(now)
    scan = None
    for stamp_s, turned in poses:
        pose = dataclasses.replace(robot.pose, yaw=turned)
        around.observe(dataclasses.replace(now, scan=scan, odom_stamp_s=stamp_s, map_pose=pose))
        scan = now.scan
    assert np.array_equal(around.survey.occupied, exact.survey.occupied)


def test_a_scan_from_before_the_first_pose_is_left_out(around, robot):
    """Where the robot was then is not known."""
    around.observe(dataclasses.replace(robot.observe(), odom_stamp_s=10.2))
    assert not around.ready


def test_a_clock_that_is_set_back_starts_the_poses_anew(around, robot):
    """Poses of the future are worth nothing."""
    now = robot.observe()
    elsewhere = Pose2D(0.5, 0.5, 3.0)
    around.observe(dataclasses.replace(now, scan=None, odom_stamp_s=99.0, map_pose=elsewhere))
    around.observe(now)
    assert around.seen_s == 10.0


@pytest.mark.parametrize(
    ("stamp_s", "x"),
    [(1.5, None), (1.8, None), (1.9, 2.0), (2.25, 2.25), (3.1, 3.0), (3.2, None)],
)
def test_a_pose_is_good_for_a_moment_before_and_after(stamp_s, x):
    """0.15 s: a scan may come just before the pose of its time; after a second it is forgotten."""
    history = PoseHistory()
    assert history.at(stamp_s) is None
    for at in (1.0, 2.0, 3.0):
        history.remember(at, Pose2D(at, 0.0, 0.0))
    pose = history.at(stamp_s)
    assert (pose and pose.x) == x


def test_what_is_near_is_seen_from_the_pose_asked_for(around, now, robot):
    """The obstacle's face is 1.1 m from the start, and 0.1 m nearer from 0.1 m on."""
    points = around.near(dataclasses.replace(robot.pose, x=robot.pose.x + 0.1))
    face = points[np.abs(points[:, 1]) < 0.02].max(axis=0)
    assert face[0] == pytest.approx(1.0, abs=0.03)


def test_the_same_map_again_changes_nothing(around, now):
    """A latched map may be sent again and again; roads are made once for a survey."""
    before, roads = around.survey, around.roads
    same = dataclasses.replace(now.grid, cells=now.grid.cells.copy())
    around.observe(dataclasses.replace(now, grid=same))
    assert around.survey is before
    assert around.roads is roads
    assert roads.survey is before


def test_another_map_keeps_what_was_seen(around, now):
    """The marks are looked up in the new map."""
    cells = now.grid.cells.copy()
    cells[20:24, 40:44] = 100
    around.observe(dataclasses.replace(now, grid=dataclasses.replace(now.grid, cells=cells)))
    assert around.mapped.clearance_of(2.1, 1.1) == 0.0
    assert around.survey.clearance_of(1.79, 1.1) < 0.05


LIDAR = Pose2D(2.02, 2.02, 0.0)
RAYS = 360
AHEAD = {0: 1.01}
HIDDEN = dict.fromkeys((-1, 0, 1), 0.8)


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


@pytest.fixture
def layer() -> ObstacleLayer:
    """Of an empty room of 4 x 4 m with walls of one cell."""
    cells = np.zeros((80, 80), dtype=np.int8)
    cells[[0, -1], :] = 100
    cells[:, [0, -1]] = 100
    return ObstacleLayer(survey(Grid(0.05, 0.0, 0.0, cells)))


def look(layer, scan):
    """Show a scan to a layer."""
    return layer.update(scan, points_of(scan), LIDAR)


def marked(layer):
    """Rows and columns of the marks."""
    return [tuple(map(int, cell)) for cell in np.argwhere(layer.marks)]


def test_what_the_map_does_not_have_is_marked_once(layer):
    """A point 1 m ahead lies in column (2.02 + 1.01) / 0.05; seen again it changes nothing."""
    assert look(layer, scan_of(AHEAD)) is True
    assert marked(layer) == [(40, 60)]
    assert look(layer, scan_of(AHEAD, 1.1)) is False


def test_what_the_map_has_is_not_marked_though_it_is_seen_with_noise(layer):
    """A wall 1.93 m away, seen 3 cm too near, is still the wall."""
    assert look(layer, scan_of({0: 1.90})) is False
    assert marked(layer) == []


HALF = np.full(180, np.inf, dtype=np.float32)


@pytest.mark.parametrize(
    ("bearing", "scan", "stays"),
    [
        pytest.param(0, scan_of(dict.fromkeys((-1, 0, 1), 1.95), 1.1), False, id="seen through"),
        pytest.param(0, scan_of({}, 1.1), False, id="inf: nothing within range, REP 117"),
        pytest.param(0, scan_of({-1: 1.95, 0: 1.95, 1: 0.8}, 1.1), True, id="a leg, missed twice"),
        pytest.param(0, scan_of(dict.fromkeys((-1, 0, 1), np.nan), 1.1), True, id="NaN: unknown"),
        pytest.param(0, scan_of(dict.fromkeys((-1, 0, 1), 0.0), 1.1), True, id="0: unknown"),
        pytest.param(0, scan_of(HIDDEN, 1.0 + NAVIGATION.obstacle_memory), True, id="hidden"),
        pytest.param(0, scan_of(HIDDEN, 1.1 + NAVIGATION.obstacle_memory), False, id="forgotten"),
        pytest.param(
            -90,
            scan_of(dict.fromkeys((89, 90, 91), 1.9), 1.1, increment=-math.tau / RAYS),
            False,
            id="seen through by rays that count clockwise",
        ),
        pytest.param(
            180,
            Scan(1.1, -math.pi / 2, math.pi / 180, 0.12, 3.5, HALF),
            True,
            id="outside the field of view",
        ),
    ],
)
def test_a_mark_goes_when_rays_pass_through_it(layer, bearing, scan, stays):
    """Who stepped aside is no obstacle any more; out of sight it is believed for a while."""
    look(layer, scan_of({bearing: 1.01}))
    (mark,) = marked(layer)
    look(layer, scan)
    assert (mark in marked(layer)) is stays


def test_marks_stay_where_they_are_when_the_map_grows(layer):
    """They move to the cells of the new map, but those that it has itself."""
    look(layer, scan_of({0: 1.01, 90: 1.01}))
    cells = np.zeros((90, 90), dtype=np.int8)
    cells[70, 50] = 100
    wider = layer.over(survey(Grid(0.05, -0.5, -0.5, cells)))
    assert marked(wider) == [(50, 70)]
