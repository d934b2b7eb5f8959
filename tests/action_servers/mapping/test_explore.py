"""Facts about exploring with a kinematic robot that maps walls as it drives."""

import dataclasses
import math
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import pytest

from action_servers.core.maneuver import ErrorCode, Finished, Grid, Observation
from action_servers.mapping import explore
from action_servers.mapping.explore import FRONTIERS, ExploreFrontiers, plan
from action_servers.mapping.occupancy import OccupancyMapper
from bt_mission.base.geometry import Pose2D
from bt_mission.robots.model import load_robot
from tests.support.fake_robot import FakeRobot

WAFFLE = load_robot("waffle")
SCAN_EVERY_S = 0.2
MAP_EVERY_S = 1.0


def box(x: float, y: float, width: float, height: float) -> list[tuple[float, float, float, float]]:
    """Four walls around a rectangle whose lower left corner is at x, y; metres."""
    right, top = x + width, y + height
    return [(x, y, right, y), (right, y, right, top), (right, top, x, top), (x, top, x, y)]


TWO_ROOMS = [*box(-1.5, -1.5, 6.0, 3.0), (1.5, -1.5, 1.5, -0.5), (1.5, 0.5, 1.5, 1.5)]
"""Two rooms of 3 m by 3 m side by side, with a door of 1 m between them."""


class MappingRobot(FakeRobot):
    """A fake robot whose observations hold the map that it has made so far, renewed once a second.

    `maps=False` keeps the first map for ever.
    """

    def __init__(self, walls: Any = TWO_ROOMS, *, maps: bool = True) -> None:
        super().__init__(WAFFLE, walls)
        self.scan_period_s = SCAN_EVERY_S
        self.mapper = OccupancyMapper(self.robot.lidar)
        self.maps = maps
        self.grid: Grid | None = None
        self.closest = math.inf
        self._mapped: Any = None
        self._map_s = -math.inf

    def observe(self) -> Observation:
        now = super().observe()
        pose = Pose2D(self.x, self.y, self.yaw)
        if now.scan is not None and now.scan is not self._mapped:
            self._mapped = now.scan
            self.mapper.add(now.scan, pose)
            self.closest = min(self.closest, float(now.scan.ranges.min()))
        if now.time_s - self._map_s > MAP_EVERY_S - 1e-6 and (self.maps or self.grid is None):
            self._map_s = now.time_s
            self.grid = self.mapper.grid(now.time_s)
        return dataclasses.replace(now, map_pose=pose, grid=self.grid)


def explored(robot: FakeRobot, max_duration: float = 0.0) -> tuple[Finished, dict[str, Any]]:
    """Let a robot explore; return the end and the result."""
    maneuver = ExploreFrontiers(WAFFLE, max_duration, 0.5)
    ended = robot.run(maneuver, 300.0)
    return ended, dict(maneuver.result())


def test_it_maps_two_rooms_and_ends_when_no_frontier_is_left():
    """Both rooms are known, nothing was touched, and the result says how much."""
    robot = MappingRobot()
    ended, result = explored(robot)
    assert (ended.status, ended.reason) == ("succeeded", "")
    assert 16.0 < result["area_mapped"] < 20.0
    assert result["frontiers_visited"] != 0
    assert robot.closest > 0.2


def test_a_room_seen_at_a_glance_needs_no_driving():
    """It looks for a moment, then ends where it stands."""
    robot = MappingRobot(box(-1.5, -1.5, 3.0, 3.0))
    assert explored(robot)[0].status == "succeeded"
    assert (robot.x, robot.y) == (0.0, 0.0)
    assert robot.time_s - 10.0 < 10.0


def test_feedback_counts_down_and_comes_at_least_once_a_second():
    """Frontiers left reach 0 in the end."""
    maneuver: Any = ExploreFrontiers(WAFFLE, 0.0, 0.5)
    reports = []

    class Listening(MappingRobot):
        def observe(self) -> Observation:
            fields = maneuver.feedback()
            if fields:
                reports.append((self.time_s, fields["frontiers_left"]))
            return super().observe()

    Listening().run(maneuver, 300.0)
    last = maneuver.feedback() or {"frontiers_left": reports[-1][1]}
    assert last["frontiers_left"] == 0
    assert max(left for _, left in reports) >= 1
    assert max(b[0] - a[0] for a, b in pairwise(reports)) <= 1.0 + 1e-6


def test_the_time_limit_ends_it_with_what_is_left():
    """After exactly 6 s, aborted; the result still tells the area."""
    robot = MappingRobot()
    ended, result = explored(robot, 6.0)
    assert (ended.status, ended.error_code) == ("aborted", ErrorCode.UNKNOWN)
    assert ended.reason.startswith("max_duration, 6 s, is over; frontiers left: ")
    assert robot.time_s == pytest.approx(16.0)
    assert result["area_mapped"] > 8.0


def test_without_a_map_it_waits_a_while_and_gives_up():
    """Five seconds; the reason asks who publishes the map."""
    robot = FakeRobot(WAFFLE)
    ended, _ = explored(robot)
    assert (ended.status, ended.error_code) == ("aborted", ErrorCode.NO_MAP)
    assert "no map has arrived" in ended.reason
    assert robot.time_s == pytest.approx(10.0 + FRONTIERS.map_wait)


def test_a_map_that_never_changes_is_no_place_to_explore():
    """It has been at a frontier and nothing new came: the mapper is not running."""
    robot = MappingRobot(maps=False)
    now = FakeRobot(WAFFLE, TWO_ROOMS).observe()
    assert now.scan is not None
    assert now.odom is not None
    for _ in range(3):
        robot.mapper.add(now.scan, now.odom)
    ended, _ = explored(robot)
    assert (ended.status, ended.error_code) == ("aborted", ErrorCode.NO_MAP)
    assert "is a mapper running" in ended.reason


def test_a_robot_that_cannot_move_gives_up_each_frontier_and_ends():
    """Aborted as blocked, with the reason of the last drive."""
    robot = MappingRobot()
    robot.stuck = True
    ended, _ = explored(robot)
    assert (ended.status, ended.error_code) == ("aborted", ErrorCode.BLOCKED)
    assert "could not be driven to" in ended.reason


def test_a_frontier_that_the_map_shuts_off_on_the_way_is_left_alone_the_second_time(monkeypatch):
    """No failure of driving: with nothing else to do, the goal succeeds."""
    legs = []

    class ShutOff:
        def __init__(self, pose, *_):
            legs.append(pose)

        def step(self, _):
            return Finished("aborted", ErrorCode.GOAL_OCCUPIED, "a wall is there")

    monkeypatch.setattr(explore, "NavigateToPose", ShutOff)
    ended, result = explored(MappingRobot())
    assert ended.status == "succeeded"
    assert len(legs) >= 2
    assert result["frontiers_visited"] == 0


def test_scans_that_stop_end_it():
    """With the code of our own actions for it."""

    class Blind(MappingRobot):
        def observe(self) -> Observation:
            now = super().observe()
            if now.time_s > 15.0:
                self.changes = {"scan": now.scan}
            return now

    ended, _ = explored(Blind())
    assert (ended.status, ended.error_code) == ("aborted", ErrorCode.NO_SCAN)
    assert "no scan" in ended.reason


def test_zeros_take_the_defaults():
    """No limit of time, and a frontier that a Waffle passes."""
    goal = SimpleNamespace(max_duration=0.0, min_frontier=0.0)
    planned = plan(goal, Observation(10.0), WAFFLE)
    assert planned.result() == {"frontiers_visited": 0, "area_mapped": 0.0}
