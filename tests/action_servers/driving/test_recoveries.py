"""Facts about Nav2's BackUp, DriveOnHeading and Wait, and what its recoveries have in common."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest
from nav2_msgs.action import BackUp, DriveOnHeading, Spin

from action_servers.core.maneuver import SUCCEEDED, ZERO, ErrorCode, Finished, Observation
from action_servers.driving import turn
from action_servers.driving.recoveries import WaitManeuver
from action_servers.driving.straight import (
    BACK_UP,
    DRIVE_ON_HEADING,
    Straight,
    plan_back_up,
    plan_drive_on_heading,
)
from action_servers.driving.turn import SPIN


@pytest.mark.parametrize(
    ("codes", "result"),
    [(SPIN, Spin.Result), (BACK_UP, BackUp.Result), (DRIVE_ON_HEADING, DriveOnHeading.Result)],
)
def test_codes_are_those_of_the_interfaces(codes, result):
    """By name and number; Spin has no INVALID_INPUT."""
    for name in ("unknown", "timeout", "tf_error", "collision_ahead", "invalid_input"):
        assert getattr(codes, name) == getattr(result, name.upper(), 0)


@pytest.mark.parametrize(
    ("ours", "nav2"),
    [
        (ErrorCode.NONE, 0),
        (ErrorCode.NO_ODOMETRY, 722),
        (ErrorCode.BLOCKED, 723),
        (ErrorCode.NO_SCAN, 720),
    ],
)
def test_our_codes_become_nav2s(ours, nav2):
    """Each has one; what Nav2 has no number for is unknown."""
    assert DRIVE_ON_HEADING.of(ours) == nav2


@pytest.mark.parametrize(
    ("maneuver", "code"),
    [
        (lambda robot: turn.Spin(7.0, 2.0, robot), 701),
        (lambda robot: Straight(-1.0, 0.1, 2.0, BACK_UP, robot), 711),
    ],
)
def test_a_time_that_is_too_short_ends_it(fake, waffle, maneuver, code):
    """At the time itself it is not yet used up."""
    base = fake(waffle)
    assert base.run(maneuver(waffle)) == Finished(
        "aborted", code, "the time allowance of 2 s is used up"
    )
    assert base.time_s == pytest.approx(12.05)


def goal(x, speed, *, y=0.0, z=0.0, allowance_s=0):
    """A goal of BackUp or DriveOnHeading."""
    return SimpleNamespace(
        target=SimpleNamespace(x=x, y=y, z=z),
        speed=speed,
        time_allowance=SimpleNamespace(sec=allowance_s, nanosec=0),
    )


@pytest.mark.parametrize("x", [0.0, 0.5, -0.5])
def test_it_drives_on_heading_by_the_distance(fake, robot, x):
    """Within five millimetres, in the sign of both; the result has the time used."""
    base = fake(robot)
    maneuver: Any = plan_drive_on_heading(
        goal(x, math.copysign(0.2, x or -1.0)), base.observe(), robot
    )
    assert base.run(maneuver) == Finished("succeeded")
    assert base.x == pytest.approx(x, abs=0.005)
    assert maneuver.result() == {"total_elapsed_time": pytest.approx(base.time_s - 10.0)}


@pytest.mark.parametrize(("x", "speed"), [(0.3, 0.1), (-0.3, -0.1), (0.3, -0.1), (-0.3, 0.1)])
def test_back_up_goes_back_whatever_the_signs(fake, waffle, x, speed):
    """As in Nav2."""
    base = fake(waffle)
    maneuver: Any = plan_back_up(goal(x, speed), base.observe(), waffle)
    assert base.run(maneuver) == Finished("succeeded")
    assert base.x == pytest.approx(-0.3, abs=0.005)
    assert min(twist.linear for twist in base.twists) == pytest.approx(-0.1)


@pytest.mark.parametrize(
    ("codes", "distance", "wall", "code"),
    [
        (BACK_UP, -2.0, (-0.6, -1.0, -0.6, 1.0), 714),
        (DRIVE_ON_HEADING, 2.0, (0.6, -1.0, 0.6, 1.0), 723),
    ],
)
def test_an_obstacle_on_the_way_is_a_collision_ahead(fake, robot, codes, distance, wall, code):
    """It stands before it, and the reason names it."""
    base = fake(robot, [wall])
    finished = base.run(Straight(distance, 0.2, 0.0, codes, robot))
    assert (finished.status, finished.error_code) == ("aborted", code)
    assert "an obstacle is in the way" in finished.reason
    while base.linear:
        base.move(ZERO)
    room = 0.6 - (robot.hull.front if distance > 0 else -robot.hull.rear)
    assert 0.02 <= room - abs(base.x) <= 0.12


def test_an_obstacle_beyond_the_end_is_none(fake, waffle):
    """It drives to 5 cm from the wall, which needs no more room than it has."""
    base = fake(waffle, [(0.6, -1.0, 0.6, 1.0)])
    assert base.run(Straight(0.48, 0.2, 0.0, DRIVE_ON_HEADING, waffle)) == Finished("succeeded")
    assert base.x == pytest.approx(0.48, abs=0.005)


def test_feedback_is_the_distance(fake, waffle):
    """Positive."""
    base = fake(waffle)
    maneuver: Any = Straight(-1.0, 0.1, 0.0, BACK_UP, waffle)
    base.run_for(maneuver, 2.0)
    assert maneuver.feedback() == {"distance_traveled": pytest.approx(-base.x, abs=0.01)}


def test_a_wait_ends_at_the_time():
    """Feedback counts down to nothing; the result is the time that has passed."""
    wait = WaitManeuver(0.15)
    left = []
    for step in range(4):
        answer = wait.step(Observation(10.0 + step * 0.05))
        assert answer == (SUCCEEDED if step == 3 else ZERO)
        left.append((wait.feedback() or {})["time_left"])
    assert left == pytest.approx([0.15, 0.1, 0.05, 0.0])
    assert wait.result() == {"total_elapsed_time": pytest.approx(0.15)}


def test_a_wait_of_no_time_ends_with_the_first_step():
    """As in Nav2."""
    assert WaitManeuver(0.0).step(Observation(10.0)) == SUCCEEDED
