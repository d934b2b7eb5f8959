import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from action_servers.core.maneuver import SUCCEEDED, ZERO, Finished
from action_servers.navigation.navigate import NavigateToPose
from action_servers.navigation.path import NAVIGATION
from bt_mission.base.geometry import Pose2D

ROOM = """
    ################
    #..............#
    #..............#
    #..............#
    #..............#
    #..R........G..#
    #..............#
    #..............#
    #..............#
    #..............#
    ################
"""
CORNER = """
    ################
    #..............#
    #..............#
    #..R...........#
    #..............#
    #..............#
    ##########.....#
    #..............#
    #..............#
    #..G...........#
    #..............#
    #..............#
    ################
"""


def changed(text, mark, column, rows):
    """A drawing with a mark in some rows, counted from the top."""
    lines = [line.strip() for line in text.strip().splitlines()]
    for row in rows:
        lines[row] = lines[row][:column] + mark + lines[row][column + len(mark) :]
    return "\n".join(lines)


BOX = changed(ROOM, "oo", 7, (4, 5, 6))
TWO_ROOMS = changed(ROOM, "#", 7, range(11))
DOOR = changed(ROOM, "#", 7, (1, 2, 3, 7, 8, 9))


@pytest.fixture
def drive(waffle, world, robot_in):
    """Drive from R to G, at first sight of `each`, and return the robot and the maneuver."""

    def run(
        text, *, start=None, goal=None, yaw=0.0, limit_s=90.0, each=lambda robot: None, **faults
    ):
        place = world(text)
        robot = robot_in(place, start)
        for name, value in faults.items():
            setattr(robot, name, value)
        maneuver = NavigateToPose(goal or dataclasses.replace(place.goal, yaw=yaw), waffle)
        robot.drive(maneuver, limit_s, each)
        return robot, maneuver

    return run


def arrived(robot, goal):
    """Whether it stands where and as it should, without having touched anything."""
    error = math.remainder(robot.pose.yaw - goal.yaw, math.tau)
    return (
        robot.finished == SUCCEEDED
        and not robot.collided
        and robot.distance_to(goal) < 0.03
        and abs(error) < 0.03
    )


def test_it_reaches_a_goal_across_a_room(drive):
    """1.8 m in a straight line, within 3 cm and 0.03 rad."""
    robot, _ = drive(ROOM)
    assert arrived(robot, robot.world.goal)
    assert robot.travelled == pytest.approx(1.8, abs=0.03)


@pytest.mark.parametrize("yaw", [-3.0, -1.0, 0.5, 2.0])
def test_it_ends_turned_to_the_goals_yaw(drive, yaw):
    """By the short way round."""
    robot, _ = drive(ROOM, yaw=yaw)
    assert arrived(robot, dataclasses.replace(robot.world.goal, yaw=yaw))


def test_it_drives_round_a_corner_without_touching_it(drive):
    """The wall's end is passed with room to spare."""
    robot, _ = drive(CORNER, yaw=3.0)
    assert arrived(robot, dataclasses.replace(robot.world.goal, yaw=3.0))


def test_it_passes_a_door_in_which_it_could_turn(drive):
    """0.6 m wide."""
    robot, _ = drive(DOOR)
    assert arrived(robot, robot.world.goal)


def test_it_stays_within_the_limits_of_the_robot(drive, waffle):
    """Velocity, and change of velocity from one control step to the next."""
    robot, _ = drive(CORNER, yaw=3.0)
    twists = [twist for _, _, twist in robot.trace]
    linear = np.array([0.0] + [twist.linear for twist in twists])
    angular = np.array([0.0] + [twist.angular for twist in twists])
    assert np.abs(linear).max() <= waffle.max_linear_velocity
    assert np.abs(angular).max() <= waffle.max_angular_velocity
    assert np.abs(np.diff(linear)).max() <= waffle.max_linear_acceleration * 0.05 + 1e-9
    assert np.abs(np.diff(angular)).max() <= waffle.max_angular_acceleration * 0.05 + 1e-9


def test_two_runs_are_the_same_to_the_last_bit(drive):
    """Nothing in it depends on chance or on a clock of its own."""
    first, _ = drive(BOX)
    second, _ = drive(BOX)
    assert first.trace == second.trace


def test_a_box_that_the_map_does_not_have_is_driven_around(drive):
    """It is seen in time: the robot never stops on its way."""
    robot, maneuver = drive(BOX)
    assert arrived(robot, robot.world.goal)
    assert robot.travelled < 2.4
    assert maneuver.feedback()["number_of_recoveries"] == 1


def test_a_box_that_appears_in_front_stops_the_robot(drive):
    """It brakes before the box, waits a second, and drives around it."""

    def appear(robot):
        if robot.pose.x > 1.3:
            robot.world.set_solid(1.8, 1.1, 0.15)

    robot, _ = drive(ROOM, each=appear)
    assert arrived(robot, robot.world.goal)
    still = [time_s for time_s, pose, twist in robot.trace if twist == ZERO and pose.x > 1.0]
    assert still


def test_who_only_crosses_the_way_is_waited_for(drive):
    """Gone within a second: the robot takes the straight way all the same."""
    seen: list[float] = []

    def cross(robot):
        if robot.pose.x > 1.2 and not seen:
            robot.world.set_solid(1.8, 1.1, 0.15)
            seen.append(robot.time_s)
        if seen and robot.time_s > seen[0] + 0.8:
            robot.world.set_solid(1.8, 1.1, 0.15, solid=False)

    robot, maneuver = drive(ROOM, each=cross)
    assert arrived(robot, robot.world.goal)
    assert robot.travelled == pytest.approx(1.8, abs=0.03)
    assert maneuver.feedback()["number_of_recoveries"] == 0


def test_a_door_that_is_blocked_for_good_ends_the_goal(drive):
    """With the planner's code, after ten seconds of waiting."""
    robot, maneuver = drive(DOOR, each=lambda robot: robot.world.set_solid(1.5, 1.1, 0.3))
    assert robot.finished.error_code == 208
    assert robot.finished.reason.startswith(
        "no path from (0.70, 1.10) to (2.50, 1.10) keeps 0.25 m"
    )
    assert robot.finished.reason.endswith("none has opened for 10.0 s")
    assert robot.time_s == 20.0
    assert not robot.collided
    assert maneuver.feedback()["number_of_recoveries"] == 1


def test_a_door_that_opens_again_is_taken(drive):
    """Patience pays."""

    def close_for_a_while(robot):
        robot.world.set_solid(1.5, 1.1, 0.3, solid=robot.time_s < 16.0)

    robot, _ = drive(DOOR, each=close_for_a_while)
    assert arrived(robot, robot.world.goal)


def test_something_on_the_goal_is_not_run_over(drive):
    """The goal is occupied for now; the code says so."""

    def put_down(robot):
        robot.world.set_solid(2.5, 1.1, 0.1)

    robot, _ = drive(ROOM, each=put_down)
    assert robot.finished.error_code == 206
    assert not robot.collided


@pytest.mark.parametrize(
    ("text", "goal", "code"),
    [
        (TWO_ROOMS, Pose2D(2.5, 1.1, 0.0), 208),
        (ROOM, Pose2D(3.1, 1.1, 0.0), 206),
        (ROOM, Pose2D(-1.0, 1.1, 0.0), 204),
    ],
)
def test_a_goal_that_the_map_rules_out_ends_at_once(drive, text, goal, code):
    """Waiting would not help: unreachable, in a wall, outside the map."""
    robot, _ = drive(text, goal=goal)
    assert robot.finished.error_code == code
    assert robot.time_s == 10.0
    assert robot.travelled == 0.0


def test_a_robot_outside_the_map_ends_at_once(drive):
    """Its own place has a code of its own."""
    robot, _ = drive(ROOM, start=Pose2D(-0.5, 1.0, 0.0))
    assert robot.finished.error_code == 203


def test_a_robot_that_faces_a_wall_backs_out_and_goes(drive):
    """It starts so close that its rear could not swing round."""
    robot, _ = drive(ROOM, start=Pose2D(2.9, 1.7, 0.0), goal=Pose2D(0.7, 0.7, 0.0))
    assert arrived(robot, Pose2D(0.7, 0.7, 0.0))
    assert 0.1 < robot.reversed_m < 0.3


def test_a_robot_that_cannot_move_gives_up(drive):
    """Motors off, or a wheel in a hole: after ten seconds, having tried anew once."""
    robot, maneuver = drive(ROOM, stuck=True)
    assert robot.finished == Finished(
        "aborted", 105, "the robot has not got away from (0.70, 1.10) for 10.0 s"
    )
    assert robot.time_s == 10.0 + NAVIGATION.patience
    assert maneuver.feedback()["number_of_recoveries"] == 1


@pytest.mark.parametrize(("fault", "code"), [("pose_lost", 102), ("scan_lost", 107)])
def test_a_robot_that_no_longer_knows_or_sees_stops_and_gives_up(drive, fault, code):
    """It stands when the last pose or scan is 0.5 s old, and ends the goal when it is 3 s old."""

    def lose(robot):
        if robot.time_s >= 13.0:
            setattr(robot, fault, True)

    robot, _ = drive(ROOM, each=lose)
    assert robot.finished.error_code == code
    driving = [time_s for time_s, _, twist in robot.trace if twist != ZERO]
    assert max(driving) <= 13.5
    assert 15.9 < robot.time_s <= 16.0


def test_a_pose_that_never_was_has_the_planners_code(drive):
    """There was no path to follow yet."""
    robot, _ = drive(ROOM, pose_lost=True)
    assert robot.finished.error_code == 202
    assert robot.travelled == 0.0


def test_a_pose_that_comes_back_lets_it_go_on(drive):
    """A second without localisation is no failure."""

    def lose(robot):
        robot.pose_lost = 13.0 <= robot.time_s < 14.5

    robot, _ = drive(ROOM, each=lose)
    assert arrived(robot, robot.world.goal)


@pytest.mark.parametrize(("at_x", "by"), [(1.2, 0.5), (2.485, 0.25)])
def test_a_robot_that_is_carried_away_plans_anew(drive, at_x, by):
    """Somebody lifts it off its path, on the way or when it has nearly arrived."""
    carried: list[float] = []

    def carry(robot):
        if robot.pose.x > at_x and not carried:
            robot.pose = dataclasses.replace(robot.pose, y=robot.pose.y + by)
            carried.append(robot.time_s)

    robot, _ = drive(ROOM, each=carry)
    assert carried
    assert arrived(robot, robot.world.goal)


def test_feedback_counts_down_to_the_goal(waffle, world, robot_in):
    """Distance falls, time passes, and what is left is told in seconds."""
    robot = robot_in(world(ROOM))
    maneuver = NavigateToPose(robot.world.goal, waffle)
    reports: list[Mapping[str, Any]] = []
    robot.drive(maneuver, each=lambda robot: reports.append(maneuver.feedback() or {}))
    reports = reports[1:]
    distances = [fields["distance_remaining"] for fields in reports]
    assert distances[0] == pytest.approx(1.8, abs=0.01)
    assert distances == sorted(distances, reverse=True)
    assert reports[20]["navigation_time"] == pytest.approx(1.0)
    assert reports[0]["estimated_time_remaining"] == pytest.approx(1.8 / 0.26, abs=0.1)
    assert reports[-1]["current_pose"] == robot.trace[-1][1]
    assert set(reports[0]) == {
        "current_pose",
        "navigation_time",
        "estimated_time_remaining",
        "number_of_recoveries",
        "distance_remaining",
    }
