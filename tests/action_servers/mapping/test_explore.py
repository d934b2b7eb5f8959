import dataclasses
from itertools import pairwise
from types import SimpleNamespace

import pytest

from action_servers.core.error_codes import ErrorCode
from action_servers.core.maneuver import Finished
from action_servers.core.tuning import FRONTIERS
from action_servers.mapping import explore
from action_servers.mapping.explore import ExploreFrontiers, plan


def goal(max_duration=0.0, min_frontier=0.0):
    """The fields of a goal."""
    return SimpleNamespace(max_duration=max_duration, min_frontier=min_frontier)


@pytest.fixture
def two_rooms(walls_of):
    """Two rooms of 3 m by 3 m side by side, with a door of 1 m between them."""
    return [*walls_of(-1.5, -1.5, 6.0, 3.0), (1.5, -1.5, 1.5, -0.5), (1.5, 0.5, 1.5, 1.5)]


def test_it_maps_two_rooms_and_ends_when_no_frontier_is_left(waffle, mapping_robot, two_rooms):
    """Both rooms are known, nothing was touched, and the result says how much."""
    robot = mapping_robot(two_rooms)
    maneuver = ExploreFrontiers(waffle, 0.0, 0.5)
    ended = robot.run(maneuver)
    assert (ended.status, ended.reason) == ("succeeded", "")
    result = maneuver.result()
    assert 16.0 < float(str(result["area_mapped"])) < 20.0
    assert result["frontiers_visited"] != 0
    assert robot.closest > 0.2


def test_a_room_seen_at_a_glance_needs_no_driving(waffle, mapping_robot, walls_of):
    """It looks for a moment, then ends where it stands."""
    robot = mapping_robot(walls_of(-1.5, -1.5, 3.0, 3.0))
    ended = robot.run(ExploreFrontiers(waffle, 0.0, 0.5))
    assert ended.status == "succeeded"
    assert (robot.fake.x, robot.fake.y) == (0.0, 0.0)
    assert robot.fake.time_s - 10.0 < 10.0


def test_feedback_counts_down_and_comes_at_least_once_a_second(waffle, mapping_robot, two_rooms):
    """Frontiers left reach 0 in the end."""
    robot = mapping_robot(two_rooms)
    maneuver = ExploreFrontiers(waffle, 0.0, 0.5)
    reports = []
    observe = robot.observe

    def listening():
        fields = maneuver.feedback()
        if fields:
            reports.append((robot.fake.time_s, int(str(fields["frontiers_left"]))))
        return observe()

    robot.observe = listening
    robot.run(maneuver)
    last = maneuver.feedback() or {"frontiers_left": reports[-1][1]}
    assert last["frontiers_left"] == 0
    assert max(left for _, left in reports) >= 1
    gaps = [b[0] - a[0] for a, b in pairwise(reports)]
    assert max(gaps) <= 1.0 + 1e-6


def test_the_time_limit_ends_it_with_what_is_left(waffle, mapping_robot, two_rooms):
    """After exactly 6 s, aborted; the result still tells the area."""
    robot = mapping_robot(two_rooms)
    maneuver = ExploreFrontiers(waffle, 6.0, 0.5)
    ended = robot.run(maneuver)
    assert ended.status == "aborted"
    assert ended.error_code == ErrorCode.UNKNOWN
    assert ended.reason.startswith("max_duration, 6 s, is over; frontiers left: ")
    assert robot.fake.time_s == pytest.approx(16.0)
    assert float(str(maneuver.result()["area_mapped"])) > 8.0


def test_without_a_map_it_waits_a_while_and_gives_up(waffle, fake):
    """Five seconds; the reason asks who publishes the map."""
    robot = fake(waffle)
    ended = robot.run(ExploreFrontiers(waffle, 0.0, 0.5))
    assert (ended.status, ended.error_code) == ("aborted", ErrorCode.NO_MAP)
    assert "no map has arrived" in ended.reason
    assert robot.time_s == pytest.approx(10.0 + FRONTIERS.map_wait)


def test_a_map_that_never_changes_is_no_place_to_explore(waffle, mapping_robot, two_rooms):
    """It has been at a frontier and nothing new came: the mapper is not running."""
    robot = mapping_robot(two_rooms, maps=False)
    for _ in range(3):
        robot.mapper.add(robot.fake.observe().scan, robot.fake.observe().odom)
    ended = robot.run(ExploreFrontiers(waffle, 0.0, 0.5))
    assert (ended.status, ended.error_code) == ("aborted", ErrorCode.NO_MAP)
    assert "is a mapper running" in ended.reason


def test_a_robot_that_cannot_move_gives_up_each_frontier_and_ends(waffle, mapping_robot, two_rooms):
    """Aborted as blocked, with the reason of the last drive."""
    robot = mapping_robot(two_rooms)
    robot.fake.stuck = True
    ended = robot.run(ExploreFrontiers(waffle, 0.0, 0.5))
    assert (ended.status, ended.error_code) == ("aborted", ErrorCode.BLOCKED)
    assert "could not be driven to" in ended.reason


def test_a_frontier_that_the_map_shuts_off_on_the_way_is_left_alone_the_second_time(
    waffle, mapping_robot, two_rooms, monkeypatch
):
    """No failure of driving: with nothing else to do, the goal succeeds."""
    legs = []

    class ShutOff:
        def __init__(self, pose, *_):
            legs.append(pose)

        def step(self, _):
            return Finished("aborted", ErrorCode.GOAL_OCCUPIED, "a wall is there")

    monkeypatch.setattr(explore, "NavigateToPose", ShutOff)
    robot = mapping_robot(two_rooms)
    maneuver = ExploreFrontiers(waffle, 0.0, 0.5)
    assert robot.run(maneuver).status == "succeeded"
    assert len(legs) >= 2
    assert maneuver.result()["frontiers_visited"] == 0


def test_scans_that_stop_end_it(waffle, mapping_robot, two_rooms):
    """With the code of our own actions for it."""
    robot = mapping_robot(two_rooms)
    maneuver = ExploreFrontiers(waffle, 0.0, 0.5)
    observe = robot.observe
    frozen = []

    def blind():
        now = observe()
        if now.time_s > 15.0:
            frozen.append(now.scan)
            now = dataclasses.replace(now, scan=frozen[0])
        return now

    robot.observe = blind
    ended = robot.run(maneuver)
    assert (ended.status, ended.error_code) == ("aborted", ErrorCode.NO_SCAN)
    assert "no scan" in ended.reason


def test_zeros_take_the_defaults(waffle, fake):
    """No limit of time, and a frontier that a Waffle passes."""
    planned = plan(goal(), fake(waffle).observe(), waffle)
    assert isinstance(planned, ExploreFrontiers)
    assert planned.result() == {"frontiers_visited": 0, "area_mapped": 0.0}
