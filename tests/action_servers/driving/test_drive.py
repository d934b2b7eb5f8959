"""Facts about the way of every driving maneuver."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

from action_servers.core.error_codes import ErrorCode
from action_servers.core.maneuver import ZERO, Finished, Held, Observation, Reason
from action_servers.driving.drive import Drive
from bt_mission.core.geometry import Twist2D


def test_it_counts_its_way(fake, waffle):
    """Metres driven, and radians turned."""
    base, drive = fake(waffle), Drive(waffle)
    for _ in range(200):
        assert drive.fault(base.observe()) is None
        base.move(Twist2D(0.02, 0.1))
    assert drive.distance == pytest.approx(0.2, abs=0.01)
    assert drive.yaw == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize(
    ("held", "end"),
    [
        (Held(Reason.BASE, "blocked", Twist2D(0.2, 0.0), 10.0), "blocked"),
        (Held(Reason.OBSTACLE, "a wall", ZERO, 8.0), "a wall, for 2 s"),
        (Held(Reason.OBSTACLE, "a wall", ZERO, 8.05), None),
        (Held(Reason.OBSTACLE, "a wall", Twist2D(0.1, 0.0), 0.0), None),
        (Held(Reason.MOVING, "a robot", ZERO, 0.0), None),
        (Held(Reason.EXECUTIVE, "late", ZERO, 0.0), None),
    ],
)
def test_it_ends_where_the_base_does_not_follow_or_stands_for_long(fake, waffle, held, end):
    """For 2 s before an obstacle; not while it gives way, or somebody holds it."""
    now = dataclasses.replace(fake(waffle).observe(), held=held)
    expected = None if end is None else Finished("aborted", ErrorCode.BLOCKED, end)
    assert Drive(waffle).fault(now) == expected


def test_rests_until_odometry_says_that_it_stands(fake, waffle):
    """Zero is commanded meanwhile."""
    base, drive = fake(waffle), Drive(waffle)
    base.linear = 0.2
    steps = 0
    while drive.rest(base.observe()) == ZERO:
        base.move(ZERO)
        steps += 1
    assert steps == 4
    assert base.linear == pytest.approx(0.0, abs=1e-9)


def test_does_not_wait_for_ever_for_a_base_to_stand(waffle):
    """Odometry without velocities ends the wait after a second."""
    drive: Any = Drive(waffle)
    assert drive.rest(Observation(5.0)) == ZERO
    assert drive.rest(Observation(5.95)) == ZERO
    assert drive.rest(Observation(6.0)) is None


def test_each_rest_has_its_own_second(waffle):
    """Between two of them a speed was asked for."""
    drive: Any = Drive(waffle)
    assert drive.rest(Observation(5.0)) == ZERO
    assert drive.speed_ahead(Observation(5.5, odom_stamp_s=5.5), 1.0, 0.2) == 0.2
    assert drive.rest(Observation(6.0)) == ZERO


def test_the_delay_of_a_command_counts_the_age_of_odometry(waffle):
    """One control step, and what has passed since the odometry."""
    now = Observation(5.0, odom_stamp_s=4.98)
    assert Drive(waffle).delay_s(now) == pytest.approx(0.07)
