"""Facts about turning on the spot: Turn, and Nav2's Spin."""

from __future__ import annotations

import itertools
import math
from types import SimpleNamespace
from typing import Any

import pytest

from action_servers.core.maneuver import SUCCEEDED, ErrorCode, Finished
from action_servers.driving.turn import Spin, Turn, plan, plan_spin
from bt_mission.base.geometry import Twist2D
from tests.support.thorough import sample

ANGLES = [1, -2, 5, 90, -90, 179, 180, -180, 181, 360, -720, 1000]


@pytest.mark.parametrize(
    ("speed", "angle"), sample(itertools.product([1.0, 0.1, 1.82], ANGLES), every=10)
)
def test_turns_by_the_angle(fake, waffle, angle, speed):
    """Within half a degree, left for positive angles, without wrapping at half a turn."""
    base = fake(waffle)
    turn: Any = Turn(math.radians(angle), speed, waffle)
    assert base.run(turn, limit_s=300.0) == SUCCEEDED
    assert math.degrees(base.yaw) == pytest.approx(angle, abs=0.5)
    assert turn.result()["angle_turned"] == pytest.approx(math.degrees(base.yaw), abs=1e-6)
    assert abs(base.angular) < 0.02


def test_turns_no_faster_than_told(fake, waffle):
    """The goal's speed is the fastest command, and the robot stays where it is."""
    base = fake(waffle)
    base.run(Turn(math.pi, 0.7, waffle))
    assert max(twist.angular for twist in base.twists) == 0.7
    assert {twist.linear for twist in base.twists} == {0.0}


def test_slows_down_near_the_end(fake, waffle):
    """The last commands fall step by step."""
    base = fake(waffle)
    base.run(Turn(math.radians(90), 1.0, waffle))
    speeds = [twist.angular for twist in base.twists]
    falling = speeds[speeds.index(1.0) :]
    assert falling == sorted(falling, reverse=True)
    assert len({round(speed, 3) for speed in falling}) >= 5


def test_an_angle_of_zero_succeeds_without_moving(fake, waffle):
    """A computed angle may be 0; the robot is there already."""
    base = fake(waffle)
    assert base.run(Turn(0.0, 1.0, waffle)) == SUCCEEDED
    assert set(base.twists) == {Twist2D()}


def test_turns_back_what_it_slid_too_far(fake, waffle):
    """A base that slides on after the stop is brought back within a degree."""
    base = fake(waffle)
    turn: Any = Turn(math.radians(30), 1.0, waffle)
    slid = False
    for _ in range(200):
        answer = turn.step(base.observe())
        if answer == SUCCEEDED:
            break
        if answer == Twist2D() and not slid:
            slid = True
            base.yaw += math.radians(4)
        base.move(answer)
    assert slid
    assert math.degrees(base.yaw) == pytest.approx(30.0, abs=1.0)


def test_feedback_tells_angle_and_rest(fake, waffle):
    """They add up to the goal, and are given only when they change."""
    base = fake(waffle)
    turn: Any = Turn(math.radians(-90), 1.0, waffle)
    base.run_for(turn, 1.0)
    reported = turn.feedback()
    assert reported["current_angle"] == pytest.approx(-50.0, abs=8.0)
    assert reported["current_angle"] + reported["remaining_angle"] == pytest.approx(-90.0)
    assert turn.feedback() is None


POST_BEHIND_RIGHT = [(0.0, -0.205, 0.0, -0.5)]
"""A thin wall that the right rear corner meets after a left turn of 49 degrees."""


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_ends_before_the_corner_behind_meets_a_wall(fake, waffle, sign):
    """The rear swings wider than the front: it slows down, stops before contact, and says why."""
    base = fake(waffle, [(0.0, -sign * 0.205, 0.0, -sign * 0.5)])
    finished = base.run(Turn(sign * math.pi, 1.0, waffle))
    assert finished.error_code == ErrorCode.BLOCKED
    side = "left" if sign > 0 else "right"
    assert finished.reason.startswith(
        f"no room to turn {side}: an obstacle is within the circle of 0.238 m that the robot"
    )
    assert abs(base.twists[-2].angular) < 0.5
    base.move(Twist2D(), 0.5)
    assert 30.0 < sign * math.degrees(base.yaw) < 45.0
    body_x = -sign * 0.205 * math.sin(base.yaw)
    body_y = -sign * 0.205 * math.cos(base.yaw)
    assert body_x < -0.197 or abs(body_y) > 0.133


@pytest.mark.parametrize("angle", [25.0, -90.0])
def test_an_obstacle_that_the_turn_does_not_reach_is_no_hindrance(fake, waffle, angle):
    """25 of the 49 degrees that are free, and the other direction."""
    base = fake(waffle, POST_BEHIND_RIGHT)
    assert base.run(Turn(math.radians(angle), 1.0, waffle)) == SUCCEEDED


def test_a_wall_outside_the_circle_is_no_hindrance(fake, waffle):
    """Two centimetres beyond the circle that the body sweeps, it turns freely."""
    side = waffle.turning_radius + 0.02
    base = fake(waffle, [(-2.0, side, 2.0, side), (-2.0, -side, 2.0, -side)])
    assert base.run(Turn(math.pi, 1.0, waffle)) == SUCCEEDED


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_no_room_at_all_ends_it_before_it_moves(fake, waffle, direction):
    """Between two posts that touch its corners behind."""
    base = fake(waffle, [(-0.15, side * 0.15, -0.15, side * 0.4) for side in (1.0, -1.0)])
    assert base.run(Turn(direction, 1.0, waffle)).error_code == ErrorCode.BLOCKED
    assert set(base.twists) == {Twist2D()}


def test_speed_zero_takes_the_default(fake, waffle):
    """1 rad/s."""
    base = fake(waffle)
    base.run(plan(SimpleNamespace(angle=90.0, angular_velocity=0.0), base.observe(), waffle))
    assert max(twist.angular for twist in base.twists) == 1.0


@pytest.mark.parametrize("yaw", [0.0, 1.57, -1.57, 7.0])
def test_a_spin_turns_by_the_angle_in_its_sign(fake, robot, yaw):
    """Not wrapped, within a degree; the result has the time used."""
    base = fake(robot)
    allowance = SimpleNamespace(sec=0, nanosec=0)
    goal = SimpleNamespace(target_yaw=yaw, time_allowance=allowance)
    spin: Any = plan_spin(goal, base.observe(), robot)
    assert base.run(spin) == Finished("succeeded")
    assert base.yaw == pytest.approx(yaw, abs=math.radians(1.0))
    assert spin.result() == {"total_elapsed_time": pytest.approx(base.time_s - 10.0)}
    assert max(abs(twist.angular) for twist in base.twists) <= 1.0


def test_feedback_of_a_spin_is_the_angle_turned(fake, waffle):
    """Signed, radians."""
    base = fake(waffle)
    spin: Any = Spin(-2.0, 0.0, waffle)
    base.run_for(spin, 1.0)
    assert spin.feedback() == {"angular_distance_traveled": pytest.approx(base.yaw, abs=0.06)}


def test_no_room_to_spin_is_a_collision_ahead(fake, waffle):
    """Code 703: a wall beside the rear corner."""
    base = fake(waffle, [(-1.0, 0.17, 1.0, 0.17)])
    finished = base.run(Spin(1.57, 0.0, waffle))
    assert (finished.status, finished.error_code) == ("aborted", 703)
