"""Facts about the way of a car: curves without obstacles, and the search around them."""

from __future__ import annotations

import dataclasses
import math
import random
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from action_servers.core.clearance import footprint
from action_servers.core.grid import survey
from action_servers.core.maneuver import SUCCEEDED
from action_servers.navigation.arcs import (
    CURVATURE_SHARE,
    KEPT_M,
    MARGINS_M,
    ArcSearch,
    ArcWay,
    HullDiscs,
)
from action_servers.navigation.navigate import NavigateToPose
from action_servers.navigation.path import cost_model
from action_servers.navigation.planner import road_map
from action_servers.navigation.reeds_shepp import Pieces, curves
from action_servers.navigation.surroundings import Surroundings
from bt_mission.base.geometry import Pose2D
from bt_mission.robots.model import load_robot

CAR = load_robot("f1tenth")
SHARPEST = CAR.drive.max_curvature

HALL = """
    ##################
    #................#
    #................#
    #................#
    #................#
    #..R.........G...#
    #................#
    #................#
    #................#
    ##################
"""
CORNER = """
    ##################
    #................#
    #................#
    #..R.............#
    #................#
    #................#
    #................#
    ########.........#
    ########.........#
    ########....G....#
    ########.........#
    ########.........#
    ##################
"""
TWO_ROOMS = """
    ################
    #.......#......#
    #.......#......#
    #..R....#...G..#
    #.......#......#
    #.......#......#
    ################
"""


def driven(start: Pose2D, pieces: Pieces, curvature: float) -> Pose2D:
    """Where pieces end."""
    x, y, yaw = start.x, start.y, start.yaw
    for side, length in pieces:
        bend = side * curvature
        after = yaw + bend * length
        if side:
            x += (math.sin(after) - math.sin(yaw)) / bend
            y -= (math.cos(after) - math.cos(yaw)) / bend
        else:
            x, y = x + length * math.cos(yaw), y + length * math.sin(yaw)
        yaw = after
    return Pose2D(x, y, yaw)


def length_of(pieces: Pieces) -> float:
    """Ahead and back."""
    return sum(abs(length) for _, length in pieces)


def test_every_curve_ends_at_the_goal_and_the_shortest_is_as_long_back() -> None:
    """For 300 pairs of poses."""
    draw = random.Random(1)
    for _ in range(300):
        start, goal = (Pose2D(*(draw.uniform(-3, 3) for _ in range(3))) for _ in range(2))
        there, back = curves(start, goal, 1.3), curves(goal, start, 1.3)
        for pieces in there:
            end = driven(start, pieces, 1.3)
            assert math.hypot(end.x - goal.x, end.y - goal.y) < 1e-6
            assert abs(math.remainder(end.yaw - goal.yaw, math.tau)) < 1e-6
        assert length_of(there[0]) == pytest.approx(length_of(back[0]))


@pytest.mark.parametrize(
    ("goal", "expected"),
    [
        (Pose2D(2.0, 0.0, 0.0), ((0, 2.0),)),
        (Pose2D(-2.0, 0.0, 0.0), ((0, -2.0),)),
        (Pose2D(0.5, 0.5, math.pi / 2), ((1, math.pi / 4),)),
        (Pose2D(-0.5, 0.5, -math.pi / 2), ((1, -math.pi / 4),)),
        # A turn around at the same place: three arcs of a sixth of a turn.
        (Pose2D(0.0, 0.0, math.pi), ((1, math.pi / 6), (-1, -math.pi / 6), (1, math.pi / 6))),
    ],
)
def test_known_curves(goal: Pose2D, expected: Pieces) -> None:
    """Of the sharpest arc of radius 0.5 m; mirrored ones are as short."""
    shortest = curves(Pose2D(0.0, 0.0, 0.0), goal, 2.0)[0]
    assert length_of(shortest) == pytest.approx(length_of(expected))
    if len(expected) == 1:
        assert [side for side, _ in shortest] == [side for side, _ in expected]


def searched(place: Any, start: Pose2D, goal: Pose2D, kept: float = KEPT_M) -> ArcWay | None:
    """The way of the car in a world."""
    search = ArcSearch(
        road_map(survey(place.grid), cost_model(CAR.passing_radius)),
        footprint(CAR),
        SHARPEST,
        (start, goal),
        kept,
    )
    while not search.is_over:
        search.advance(50)
    return search.way


@pytest.mark.parametrize(
    ("text", "yaw", "kept"), [(HALL, 0.0, MARGINS_M[0]), (CORNER, 90.0, MARGINS_M[1])]
)
def test_a_way_is_one_that_the_car_can_drive_with_room_around_its_hull(
    world: Any, text: str, yaw: float, kept: float
) -> None:
    """It begins and ends exactly, is no sharper than a share of the sharpest arc, and meets."""
    place = world(text)
    goal = dataclasses.replace(place.goal, yaw=math.radians(yaw))
    way = searched(place, place.start, goal, kept)
    assert way is not None
    assert HullDiscs(footprint(CAR)).room(way.poses, survey(place.grid)).min() > kept - 0.02
    x, y, at = way.poses[0]
    assert (x, y, at) == pytest.approx((place.start.x, place.start.y, place.start.yaw))
    x, y, at = way.poses[-1]
    assert (x, y) == pytest.approx((goal.x, goal.y))
    assert math.remainder(at - goal.yaw, math.tau) == pytest.approx(0.0, abs=1e-6)
    for stroke in way.strokes:
        ahead = np.diff(stroke.path.points, axis=0)
        facing = np.column_stack((np.cos(stroke.yaws[:-1]), np.sin(stroke.yaws[:-1])))
        assert (np.sign((ahead * facing).sum(axis=1)) == stroke.direction).all()
        assert np.abs(stroke.bends).max() <= CURVATURE_SHARE * SHARPEST + 1e-9
    for stroke, following in pairwise(way.strokes):
        assert stroke.path.points[-1] == pytest.approx(following.path.points[0])
        assert stroke.direction == -following.direction


def test_there_is_no_way_through_a_wall_nor_to_a_place_in_it(world: Any) -> None:
    """The search ends by itself."""
    place = world(TWO_ROOMS)
    assert searched(place, place.start, place.goal) is None
    assert searched(place, place.start, Pose2D(1.6, 0.9, 0.0)) is None


def test_a_car_drives_its_way_to_the_goal(world: Any, robot_in: Any) -> None:
    """It turns round in a corner, and touches nothing."""
    place = world(CORNER)
    goal = dataclasses.replace(place.goal, yaw=math.radians(90.0))
    robot = robot_in(place, model=CAR)
    paths: list[Any] = []
    maneuver = NavigateToPose(goal, CAR, Surroundings(CAR, publish=paths.append))
    assert robot.drive(maneuver, 120.0) == SUCCEEDED
    assert not robot.collided
    assert robot.distance_to(goal) < 0.1
    assert abs(math.remainder(robot.pose.yaw - goal.yaw, math.tau)) < 0.05
    assert robot.reversed_m > 0.5
    assert robot.travelled < 6.0
    assert maneuver.recoveries == 0
    first, *_, last = paths[1]["poses"]
    assert (first.x, first.y) == pytest.approx((place.start.x, place.start.y))
    assert (last.x, last.y) == pytest.approx((goal.x, goal.y), abs=0.1)
    bends = [abs(t.angular) - SHARPEST * abs(t.linear) for _, _, t in robot.trace]
    assert max(bends) < 1e-9
