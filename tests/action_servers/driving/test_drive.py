"""Facts about the guard of every driving maneuver."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

from action_servers.core.maneuver import ZERO, ErrorCode, Finished, Observation
from action_servers.driving.drive import CourseWatch, DriveGuard, ProgressWatch
from bt_mission.core.geometry import Twist2D


def test_a_base_that_obeys_is_never_blocked(fake, waffle):
    """Not even at a tenth of its speed."""
    base, drive = fake(waffle), DriveGuard(waffle)
    for _ in range(200):
        assert drive.fault(base.observe()) is None
        base.move(drive.command(base.observe(), Twist2D(0.02, 0.1)))
    assert drive.distance == pytest.approx(0.2, abs=0.01)
    assert drive.yaw == pytest.approx(1.0, abs=0.02)


def test_each_axis_is_watched(fake, waffle):
    """A base that drives but does not turn is blocked too."""
    base, drive = fake(waffle), DriveGuard(waffle)
    for _ in range(100):
        drive.fault(base.observe())
        answer: Any = drive.command(base.observe(), Twist2D(0.1, 0.5))
        if isinstance(answer, Finished):
            break
        base.move(Twist2D(0.1, 0.0))
    assert answer.reason == (
        "blocked: commanded 0.50 rad/s, no progress for 2 s; "
        "the base is held, or refuses commands as late"
    )


def test_a_base_that_rests_is_not_blocked():
    """The two seconds count only while something is commanded."""
    watch: Any = ProgressWatch("m/s")
    assert watch.update(0.0, 0.0, 0.2) is None
    assert watch.update(1.9, 0.0, 0.0) is None
    assert watch.update(3.8, 0.0, 0.2) is None
    assert watch.update(3.9, 0.0, 0.2).error_code == ErrorCode.BLOCKED


def test_a_base_that_goes_round_in_circles_is_astray():
    """One wheel is blocked: it makes way, but not straight on; two seconds of that are enough."""
    watch: Any = CourseWatch()
    turning = Twist2D(0.1, 0.7)
    ends = []
    for number, (measured, commanded) in enumerate(
        [
            (turning, Twist2D(0.2, 0.0)),
            (Twist2D(0.2, 0.2), Twist2D(0.2, 0.0)),  # no more than an uneven floor does
            (turning, Twist2D(0.2, 0.0)),
            (turning, Twist2D(0.2, 0.5)),  # as it was told
            (turning, Twist2D(0.2, 0.0)),
            (turning, Twist2D(0.2, 0.0)),
            (None, Twist2D(0.2, 0.0)),  # odometry without velocities
            (turning, Twist2D(0.2, 0.0)),
            (turning, Twist2D(0.2, 0.0)),
            (turning, Twist2D(0.2, 0.0)),
        ]
    ):
        ends.append(watch.update(Observation(float(number), velocity=measured), commanded))
    assert ends[:-1] == [None] * 9
    assert (ends[-1].error_code, ends[-1].reason) == (
        ErrorCode.BLOCKED,
        "astray: commanded straight on, turning at 0.70 rad/s for 2 s; does a wheel block or slip?",
    )


def test_rests_until_odometry_says_that_it_stands(fake, waffle):
    """Zero is commanded meanwhile."""
    base, drive = fake(waffle), DriveGuard(waffle)
    base.linear = 0.2
    steps = 0
    while drive.rest(base.observe()) == ZERO:
        base.move(ZERO)
        steps += 1
    assert steps == 4
    assert base.linear == pytest.approx(0.0, abs=1e-9)


def test_does_not_wait_for_ever_for_a_base_to_stand(waffle):
    """Odometry without velocities ends the wait after a second."""
    drive: Any = DriveGuard(waffle)
    assert drive.rest(Observation(5.0)) == ZERO
    assert drive.rest(Observation(5.95)) == ZERO
    assert drive.rest(Observation(6.0)) is None


def test_the_delay_of_a_command_counts_the_age_of_odometry(waffle):
    """One control step, and what has passed since the odometry."""
    now = Observation(5.0, odom_stamp_s=4.98)
    assert DriveGuard(waffle).delay_s(now) == pytest.approx(0.07)


@pytest.mark.parametrize("lost", ["scan", "odometry"])
def test_the_base_is_held_before_a_lost_sensor_is_given_up(fake, waffle, lost):
    """At an age of 0.6 s; a newer scan lets it go on, and waiting is not being blocked."""
    base, drive = fake(waffle), DriveGuard(waffle)
    seen = base.observe()
    twist = Twist2D(0.2, 0.0)
    for age, expected in ((0.5, twist), (0.6, twist), (0.65, ZERO), (0.95, ZERO), (0.0, twist)):
        changes: Any = {"time_s": seen.time_s + age, "odom_stamp_s": seen.time_s + age}
        if lost == "odometry":
            changes["odom_stamp_s"] = seen.time_s
        scan_s = seen.time_s if lost == "scan" else seen.time_s + age
        changes["scan"] = dataclasses.replace(seen.scan, stamp_s=scan_s)
        assert drive.command(dataclasses.replace(seen, **changes), twist) == expected
