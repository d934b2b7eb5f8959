"""Facts about a base that gives way to what moves; noise on every ray, exact courses."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import pytest

from action_servers.core.maneuver import Maneuver
from action_servers.driving.explore_forward import ExploreForward
from action_servers.driving.move import Move
from action_servers.driving.straight import BACK_UP, DRIVE_ON_HEADING, Straight
from action_servers.driving.turn import Turn
from bt_mission.base.geometry import Twist2D
from bt_mission.robots.model import RobotModel
from sim.world.motion import Circling, Course, Drifting
from tests.support.fake_robot import Wall
from tests.support.moving_robot import Mover, MovingWorld
from tests.support.thorough import sample

ROOM = [
    (-3.0, -3.0, 3.0, -3.0),
    (3.0, -3.0, 3.0, 3.0),
    (3.0, 3.0, -3.0, 3.0),
    (-3.0, 3.0, -3.0, -3.0),
]
SPEEDS = (0.1, 0.3, 0.5)
GIVES_WAY = "something comes at the robot: it gives way"
TRAPPED = "something comes at the robot, and there is no way out: it stands still"


def explore(robot: RobotModel) -> Maneuver:
    """Drive ahead at full speed."""
    return ExploreForward(robot.max_linear_velocity, 0.3, robot)


def creep(robot: RobotModel) -> Maneuver:
    """Drive ahead slowly."""
    return Move(12, Twist2D(0.1, 0.0), robot)


def turn(robot: RobotModel) -> Maneuver:
    """Turn slowly, for longer than any meeting."""
    return Turn(12.0, 0.3, robot)


MEETINGS: dict[str, tuple[Callable[[RobotModel], Maneuver], Callable[[float], Course]]] = {
    "head on": (explore, lambda speed: Drifting((2.2, 0.0), (-speed, 0.0))),
    "crossing": (explore, lambda speed: Drifting((1.0, -3.8 * speed), (0.0, speed))),
    "corner": (explore, lambda speed: Drifting((2.0, 3 * speed), (-speed, -0.6 * speed))),
    "from behind": (creep, lambda speed: Drifting((-2.0, 0.05), (speed, 0.0))),
    "from the side": (turn, lambda speed: Drifting((0.0, 2.0), (0.0, -speed))),
    "on a circle": (creep, lambda speed: Circling((1.4, 0.0), (0.0, 0.0), math.tau * 1.4 / speed)),
}


@pytest.mark.parametrize(
    ("meeting", "speed"), sample(itertools.product(MEETINGS, SPEEDS), every=12)
)
def test_what_moves_does_not_run_into_a_robot_that_has_room(waffle, meeting, speed):
    """Whatever side it comes from; the goal goes on afterwards, or has succeeded."""
    maneuver, course = MEETINGS[meeting]
    world = MovingWorld(waffle, [Mover(course(speed))], ROOM)
    world.start(maneuver(waffle))
    world.run(12.0)
    assert world.least_gap > 0.03
    assert [outcome.status for outcome in world.outcomes] in ([], ["succeeded"])


@pytest.mark.parametrize("meeting", ["head on", "from behind", "from the side"])
def test_it_would_be_run_into_if_it_did_not_give_way(waffle, meeting):
    """The same meetings, with give_way_time 0: the scenarios can fail."""
    maneuver, course = MEETINGS[meeting]
    world = MovingWorld(waffle, [Mover(course(0.3))], ROOM, gives_way=False)
    world.start(maneuver(waffle))
    world.run(12.0)
    assert world.least_gap <= 0.0
    assert world.held == 0


def test_it_is_told_once_and_in_the_result(waffle):
    """However often it gives way; the way is in the result's reason."""
    world = MovingWorld(waffle, [Mover(Drifting((2.2, 0.0), (-0.3, 0.0)))], ROOM)
    world.start(explore(waffle))
    world.run(20.0)
    assert world.notes == [GIVES_WAY]
    (outcome,) = world.outcomes
    assert outcome.status == "succeeded"
    assert outcome.reason.startswith("gave way ")


def test_in_a_dead_end_it_stands_still_and_says_so(waffle):
    """Walls at both sides and behind: backing off ends at the wall, which it does not touch."""
    alley: list[Wall] = [
        (-0.6, -0.3, 3.0, -0.3),
        (-0.6, 0.3, 3.0, 0.3),
        (-0.6, -0.3, -0.6, 0.3),
        (3.0, -0.3, 3.0, 0.3),
    ]
    world = MovingWorld(waffle, [Mover(Drifting((2.5, 0.0), (-0.3, 0.0)))], alley)
    world.start(explore(waffle))
    world.run(9.0)
    assert world.notes[-1] == TRAPPED
    assert world.base.linear == world.base.angular == 0.0
    assert world.base.x + waffle.hull.rear > -0.6
    assert world.least_gap <= 0.0


def test_an_idle_base_does_not_move(waffle):
    """A robot that moves without a goal is a surprise; so it stands, and is run into."""
    world = MovingWorld(waffle, [Mover(Drifting((2.0, 0.0), (-0.3, 0.0)))], ROOM)
    world.run(8.0)
    assert (world.base.x, world.base.y, world.base.yaw) == (0.0, 0.0, 0.0)
    assert world.least_gap <= 0.0


def test_a_base_that_is_held_does_not_move(waffle):
    """Whoever holds it has the last word."""
    world = MovingWorld(waffle, [Mover(Drifting((2.0, 0.0), (-0.3, 0.0)))], ROOM)
    world.pilot.hold()
    world.start(turn(waffle))
    world.run(8.0)
    assert (world.base.x, world.base.y, world.base.yaw) == (0.0, 0.0, 0.0)


@pytest.mark.thorough
def test_one_goal_gives_way_so_far_and_no_farther(waffle):
    """What follows it for ever does not drive it through the world: give_way_distance."""
    world = MovingWorld(waffle, [Mover(Drifting((-1.5, 0.0), (0.2, 0.0)))], [])
    world.start(Move(60, Twist2D(0.0, 0.02), waffle))
    world.run(40.0)
    assert world.give_way.way <= 1.0 + 0.26 * 0.2


@pytest.mark.parametrize(
    ("distance", "codes", "course"),
    sample(
        [
            (1.5, DRIVE_ON_HEADING, Drifting((1.2, 2.5), (-0.1, -0.4))),
            (-1.5, BACK_UP, Drifting((-1.2, 1.5), (0.0, -0.2))),
        ],
        4,
    ),
    ids=["ahead", "back"],
)
def test_a_straight_drive_makes_up_for_the_way_it_gave_up(waffle, distance, codes, course):
    """The way by which it gave way is no part of the distance that was asked for."""
    world = MovingWorld(waffle, [Mover(course)], [])
    world.start(Straight(distance, 0.2, 0.0, codes, waffle))
    world.run(40.0)
    (outcome,) = world.outcomes
    assert outcome.status == "succeeded"
    assert world.least_gap > 0.03
    assert world.give_way.way > 0.1
    assert math.hypot(world.base.x, world.base.y) == pytest.approx(1.5, abs=0.05)


def test_a_goal_with_a_time_ends_in_time(waffle):
    """Giving way uses up the goal's time like anything else."""
    world = MovingWorld(waffle, [Mover(Drifting((1.5, 0.0), (-0.2, 0.0)))], ROOM)
    world.start(Move(6, Twist2D(0.05, 0.0), waffle))
    world.run(7.2)
    assert [outcome.status for outcome in world.outcomes] == ["succeeded"]


@pytest.mark.parametrize(
    ("linear", "rate", "turn_s"),
    sample(itertools.product([0.26, 0.0], [1.82, 0.0, 0.3, 1.0], [0.2, 0.0]), every=16),
)
def test_nothing_that_stands_still_is_given_way_to(robot, linear, rate, turn_s):
    """Walls, corners and posts, with noise, while the robot drives and turns at any speed."""
    posts = [wall for x, y in ((0.9, 0.9), (-0.8, 1.1), (1.0, -1.2)) for wall in _post(x, y)]
    world = MovingWorld(robot, [], [*_square(1.9), *posts], turn_s=turn_s)
    top = Twist2D(min(linear, robot.max_linear_velocity), min(rate, robot.max_angular_velocity))
    world.start(Move(5, top, robot))
    world.run(5.0)
    world.start(Move(5, Twist2D(-top.linear, -top.angular), robot))
    world.run(5.0)
    assert world.held == 0
    assert world.notes == []


def test_what_comes_into_view_does_not_move(waffle):
    """A post behind a corner appears to the robot that passes it: it was never seen to be away."""
    corner: list[Wall] = [(0.4, 0.35, 0.6, 0.35), (0.4, 0.35, 0.4, 0.6)]
    world = MovingWorld(waffle, [], [*ROOM, *corner, *_post(0.8, 0.45)])
    world.start(Move(6, Twist2D(0.2, 0.0), waffle))
    world.run(6.0)
    assert world.held == 0


def test_a_clock_that_is_set_back_does_not_end_it(waffle):
    """As a simulator that begins anew does: it looks again from then on."""
    world = MovingWorld(waffle, [Mover(Drifting((2.2, 0.0), (-0.3, 0.0)))], ROOM)
    world.start(turn(waffle))
    world.run(2.0)
    world.base.time_s -= 2.0
    world.run(0.1)
    assert [outcome.reason for outcome in world.outcomes] == [
        "the ROS clock was set back by 1.95 s"
    ]
    world.start(turn(waffle))
    world.run(8.0)
    assert world.least_gap > 0.03
    assert world.notes == [GIVES_WAY]


def _square(half: float) -> list[Wall]:
    corners = [(-half, -half), (half, -half), (half, half), (-half, half)]
    return [(*a, *b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]


def _post(x: float, y: float) -> list[Wall]:
    return [(x + a, y + b, x + c, y + d) for a, b, c, d in _square(0.05)]
