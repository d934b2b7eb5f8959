"""Facts about turning to an angle, and not into an obstacle."""

from __future__ import annotations

import math
from typing import Any

import pytest

from action_servers.core.error_codes import ErrorCode
from action_servers.core.maneuver import Finished
from action_servers.driving.drive import Drive
from action_servers.driving.turn import ARRIVED_WITHIN, Rotation
from bt_mission.core.geometry import Twist2D

POST_BEHIND_RIGHT = (0.0, -0.205, 0.0, -0.5)
"""A thin wall that the right rear corner meets after a left turn of 49 degrees."""


def turn(base: Any, target: float, speed: float = 1.0) -> Any:
    """Turn until the rotation has an answer other than a velocity."""
    drive = Drive(base.robot)
    rotation = Rotation(drive, base.robot)

    def step(now: Any) -> Any:
        assert drive.fault(now) is None
        return rotation.towards(now, target, speed)

    for _ in range(400):
        answer = base.step(step)
        if not isinstance(answer, Twist2D):
            return answer
    raise AssertionError("never there")


def test_it_is_there_within_a_third_of_a_degree(fake, robot):
    """None means there; the robot may still have to come to rest."""
    base = fake(robot)
    assert turn(base, 1.0) is None
    assert abs(base.yaw - 1.0) <= ARRIVED_WITHIN


def test_it_is_there_at_once_when_nothing_is_left(fake, waffle):
    """Nothing is commanded."""
    base = fake(waffle)
    assert turn(base, 0.004) is None
    assert base.twists == []


def test_an_obstacle_beyond_the_target_does_not_matter(fake, waffle):
    """25 of the 49 degrees that are free."""
    base = fake(waffle, [POST_BEHIND_RIGHT])
    assert turn(base, math.radians(25.0)) is None


def test_it_slows_down_for_an_obstacle_before_the_target(fake, waffle):
    """And ends before contact, telling the side and what was left."""
    base = fake(waffle, [POST_BEHIND_RIGHT])
    finished = turn(base, math.radians(90.0))
    assert isinstance(finished, Finished)
    assert finished.error_code == ErrorCode.BLOCKED
    assert finished.reason.startswith(
        "no room to turn left: an obstacle is within the circle of 0.238 m that the robot"
    )
    assert base.twists[-1].angular < 0.5
    base.move(Twist2D(), 0.5)
    assert math.degrees(base.yaw) < 45.0


def test_the_other_direction_is_judged_on_its_own(fake, waffle):
    """The same wall leaves 90 degrees to the right."""
    base = fake(waffle, [POST_BEHIND_RIGHT])
    assert turn(base, math.radians(-90.0)) is None


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_no_room_at_all_ends_it_before_it_moves(fake, waffle, direction):
    """Between two posts that touch its corners behind."""
    posts = [(-0.15, side * 0.15, -0.15, side * 0.4) for side in (1.0, -1.0)]
    base = fake(waffle, posts)
    finished = turn(base, direction)
    assert finished.error_code == ErrorCode.BLOCKED
    assert base.twists == [Twist2D()]
