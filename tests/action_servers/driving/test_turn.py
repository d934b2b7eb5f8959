"""Facts about turning on the spot."""

from __future__ import annotations

import itertools
import math
from types import SimpleNamespace
from typing import Any

import pytest

from action_servers.core.error_codes import ErrorCode
from action_servers.core.maneuver import SUCCEEDED
from action_servers.driving.turn import Turn, plan
from bt_mission.core.geometry import Twist2D
from tests.support.thorough import sample

ANGLES = [1, -2, 5, 90, -90, 179, 180, -180, 181, 360, -720, 1000]


@pytest.mark.parametrize(
    ("speed", "angle"), sample(itertools.product([1.0, 0.1, 1.82], ANGLES), every=5)
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
    assert base.yaw == 0.0


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


def test_blocked_robot_gives_up(fake, waffle):
    """A base that does not turn ends the goal after two seconds."""
    base = fake(waffle)
    base.stuck = True
    finished = base.run(Turn(1.0, 1.0, waffle))
    assert finished.error_code == ErrorCode.BLOCKED
    assert finished.reason == (
        "blocked: commanded 1.00 rad/s, no progress for 2 s; "
        "the base is held, or refuses commands as late"
    )
    assert base.time_s == pytest.approx(12.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_ends_before_the_corner_behind_meets_a_wall(fake, waffle, sign):
    """The rear swings wider than the front: it stops before contact, and says why."""
    base = fake(waffle, [(0.0, -sign * 0.205, 0.0, -sign * 0.5)])
    finished = base.run(Turn(sign * math.pi, 1.0, waffle))
    assert finished.error_code == ErrorCode.BLOCKED
    side = "left" if sign > 0 else "right"
    assert finished.reason.startswith(f"no room to turn {side}: an obstacle is within")
    base.move(Twist2D(), 0.5)
    # The corner behind on that side would meet the wall after 49 degrees.
    assert 30.0 < sign * math.degrees(base.yaw) < 45.0
    body_x = -sign * 0.205 * math.sin(base.yaw)
    body_y = -sign * 0.205 * math.cos(base.yaw)
    assert body_x < -0.197 or abs(body_y) > 0.133


def test_a_wall_outside_the_circle_is_no_hindrance(fake, waffle):
    """Two centimetres beyond the circle that the body sweeps, it turns freely."""
    side = waffle.turning_radius + 0.02
    base = fake(waffle, [(-2.0, side, 2.0, side), (-2.0, -side, 2.0, -side)])
    assert base.run(Turn(math.pi, 1.0, waffle)) == SUCCEEDED


def goal(**changes: Any) -> Any:
    """A sound goal, with changes."""
    return SimpleNamespace(**({"angle": 90.0, "angular_velocity": 0.0} | changes))


def test_speed_zero_takes_the_default(fake, waffle):
    """1 rad/s."""
    base = fake(waffle)
    base.run(plan(goal(), base.observe(), waffle))
    assert max(twist.angular for twist in base.twists) == 1.0
