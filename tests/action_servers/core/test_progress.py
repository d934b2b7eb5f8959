"""Facts about odometry that is added up, and a base that follows its commands, or does not."""

from __future__ import annotations

from typing import Any

import pytest

from action_servers.core.maneuver import Observation
from action_servers.core.progress import CourseWatch, Odometer, Progress, ProgressChecker
from bt_mission.base.geometry import Pose2D, Twist2D
from bt_mission.robots.model import load_robot
from tests.support.fake_robot import in_the_open


@pytest.mark.parametrize(
    ("poses", "distance", "reason"),
    [
        ([(1.0, 5.0, 2.0)], 0.0, None),
        ([(1.0 + x, x, 0.0) for x in (0.0, 0.1, 0.2)] + [(2.0, 0.0, 0.0)], 0.4, None),
        ([(1.0, 0.0, 0.0), (1.5, 0.1, 0.0), (1.5, 0.1, 0.0)], 0.1, None),
        ([(1.0, 0.0, 0.0), (1.8, 0.2, 0.0)], 0.2, None),
        ([(10.0, 2.0, 0.0), (10.05, 0.0, 0.0)], 0.0, "2.00 m in 0.050 s"),
        ([(10.0, 2.0, 0.0), (7.0, 0.0, 0.0)], 0.0, "2.00 m in -3.000 s"),
        ([(1.0, 0.0, 2.0), (1.05, 0.0, 0.0)], 0.0, "-115 deg in 0.050 s"),
    ],
    ids=["start", "there and back", "twice", "a gap", "reset", "stamps go back", "heading"],
)
def test_odometry_is_added_up_and_a_reset_is_told(poses, distance, reason):
    """Metres and radians along the path; a jump adds nothing, a long gap allows a long way."""
    odometer = Odometer(max_linear=0.26, max_angular=1.82)
    assert odometer.update(Observation(1.0)) is None
    answers = [
        odometer.update(Observation(stamp_s, odom=Pose2D(x, 0.0, yaw), odom_stamp_s=stamp_s))
        for stamp_s, x, yaw in poses
    ]
    expected = reason and f"odometry jumped by {reason}; was it reset?"
    assert answers == [None] * (len(poses) - 1) + [expected]
    assert odometer.distance == pytest.approx(distance)
    assert odometer.yaw == 0.0


def test_a_base_that_obeys_is_never_blocked(fake, waffle):
    """Not even at a tenth of its speed."""
    base, progress = fake(waffle), Progress(waffle, 2.0)
    for _ in range(200):
        assert progress.fault(base.observe(), Twist2D(0.02, 0.1)) is None
        base.move(Twist2D(0.02, 0.1))


def test_each_axis_is_watched(fake, waffle):
    """A base that drives but does not turn is blocked too."""
    base, progress = fake(waffle), Progress(waffle, 2.0)
    faults = []
    for _ in range(42):
        faults.append(progress.fault(base.observe(), Twist2D(0.1, 0.5)))
        base.move(Twist2D(0.1, 0.0))
    assert faults[:-2] == [None] * 40
    assert faults[-1] == (
        "blocked: commanded 0.50 rad/s, no progress for 2 s; "
        "the base is held, or refuses commands as late"
    )


def test_a_base_that_rests_is_not_blocked():
    """The two seconds count only while something is commanded."""
    progress = Progress(load_robot("waffle"), 2.0)
    faults = [
        progress.fault(in_the_open(time_s), Twist2D(speed, 0.0))
        for time_s, speed in ((0.0, 0.2), (1.9, 0.0), (3.8, 0.2), (3.9, 0.2))
    ]
    assert faults[:-1] == [None] * 3
    assert str(faults[-1]).startswith("blocked: commanded 0.20 m/s")


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
        ends.append(watch.fault(Observation(float(number), velocity=measured), commanded))
    assert ends[:-1] == [None] * 9
    assert ends[-1] == (
        "astray: commanded straight on, turning at 0.70 rad/s for 2 s; does a wheel block or slip?"
    )


def test_time_counts_from_the_last_move_that_matters():
    """Trembling by a centimetre is none, 0.06 m is, and so is a turn by 0.3 rad."""
    progress = ProgressChecker()
    times = [
        (10.0, Pose2D(0.0, 0.0, 0.0), 0.0),
        (11.0, Pose2D(0.01, 0.0, 0.0), 1.0),
        (12.0, Pose2D(0.06, 0.0, 0.0), 0.0),
        (13.0, Pose2D(0.06, 0.0, 0.1), 1.0),
        (14.0, Pose2D(0.06, 0.0, 0.3), 0.0),
    ]
    for time_s, pose, standing_s in times:
        assert progress.standing_s(pose, time_s) == standing_s


def test_restarting_counts_from_now():
    """Waiting on purpose is not being stuck."""
    progress = ProgressChecker()
    progress.standing_s(Pose2D(0.0, 0.0, 0.0), 10.0)
    progress.restart()
    assert progress.standing_s(Pose2D(0.0, 0.0, 0.0), 15.0) == 0.0
