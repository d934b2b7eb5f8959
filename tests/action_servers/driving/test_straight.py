"""Facts about Nav2's BackUp and DriveOnHeading."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from action_servers.core.error_codes import BACK_UP, DRIVE_ON_HEADING
from action_servers.core.maneuver import ZERO, Finished
from action_servers.driving.straight import Straight, plan_back_up, plan_drive_on_heading


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
    maneuver = plan_drive_on_heading(goal(x, math.copysign(0.2, x or -1.0)), base.observe(), robot)
    assert isinstance(maneuver, Straight)
    assert base.run(maneuver) == Finished("succeeded")
    assert base.x == pytest.approx(x, abs=0.005)
    assert maneuver.result() == {"total_elapsed_time": pytest.approx(base.time_s - 10.0)}


@pytest.mark.parametrize(("x", "speed"), [(0.3, 0.1), (-0.3, -0.1), (0.3, -0.1), (-0.3, 0.1)])
def test_back_up_goes_back_whatever_the_signs(fake, waffle, x, speed):
    """As in Nav2."""
    base = fake(waffle)
    maneuver = plan_back_up(goal(x, speed), base.observe(), waffle)
    assert isinstance(maneuver, Straight)
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
    """It stands before it, and feedback and reason have the distance."""
    base = fake(robot, [wall])
    maneuver = Straight(distance, 0.2, 0.0, codes, robot)
    finished = base.run(maneuver)
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


def test_a_time_that_is_too_short_ends_it(fake, waffle):
    """Code 711."""
    finished = fake(waffle).run(Straight(-1.0, 0.1, 2.0, BACK_UP, waffle))
    assert (finished.status, finished.error_code) == ("aborted", 711)


def test_feedback_is_the_distance(fake, waffle):
    """Positive, when it has changed."""
    base = fake(waffle)
    maneuver = Straight(-1.0, 0.1, 0.0, BACK_UP, waffle)
    base.run_for(maneuver, 2.0)
    feedback: Any = maneuver.feedback()
    assert feedback == {"distance_traveled": pytest.approx(-base.x, abs=0.01)}
    assert maneuver.feedback() is None
