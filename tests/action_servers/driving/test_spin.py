"""Facts about Nav2's Spin."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from action_servers.core.maneuver import Finished
from action_servers.driving.turn import Spin, plan_spin


def goal(yaw, allowance_s=0):
    """A goal of Spin."""
    return SimpleNamespace(
        target_yaw=yaw, time_allowance=SimpleNamespace(sec=allowance_s, nanosec=0)
    )


@pytest.mark.parametrize("yaw", [0.0, 1.57, -1.57, 7.0])
def test_it_turns_by_the_angle_in_its_sign(fake, robot, yaw):
    """Not wrapped, within a degree; the result has the time used."""
    base = fake(robot)
    spin = plan_spin(goal(yaw), base.observe(), robot)
    assert isinstance(spin, Spin)
    assert base.run(spin) == Finished("succeeded")
    assert base.yaw == pytest.approx(yaw, abs=math.radians(1.0))
    assert spin.result() == {"total_elapsed_time": pytest.approx(base.time_s - 10.0)}
    assert max(abs(twist.angular) for twist in base.twists) <= 1.0


def test_feedback_is_the_angle_turned(fake, waffle):
    """Signed, radians, when it has changed."""
    base = fake(waffle)
    spin = Spin(-2.0, 0.0, waffle)
    base.run_for(spin, 1.0)
    feedback: Any = spin.feedback()
    assert feedback == {"angular_distance_traveled": pytest.approx(base.yaw, abs=0.06)}
    assert spin.feedback() is None


def test_a_time_that_is_too_short_ends_it(fake, waffle):
    """Code 701."""
    finished = fake(waffle).run(Spin(7.0, 2.0, waffle))
    assert (finished.status, finished.error_code) == ("aborted", 701)


def test_no_room_to_turn_is_a_collision_ahead(fake, waffle):
    """Code 703: a wall beside the rear corner."""
    base = fake(waffle, [(-1.0, 0.17, 1.0, 0.17)])
    finished = base.run(Spin(1.57, 0.0, waffle))
    assert (finished.status, finished.error_code) == ("aborted", 703)
