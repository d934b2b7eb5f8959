import dataclasses

import numpy as np
import pytest

from action_servers.core.maneuver import Finished, Grid, Observation, Scan
from action_servers.navigation.senses import ProgressChecker, Senses
from bt_mission.core.geometry import Pose2D

GRID = Grid(0.05, 0.0, 0.0, np.zeros((2, 2), dtype=np.int8))
SCAN = Scan(10.0, 0.0, 0.1, 0.12, 3.5, np.ones(3, dtype=np.float32))
NOW = Observation(10.0, odom_stamp_s=10.0, scan=SCAN, map_pose=Pose2D(0.0, 0.0, 0.0), grid=GRID)


def at(time_s, *, pose_s=None, seen_s=None):
    """Check at a time, from stamps of pose and scan; a goal that began at 10 s."""
    now = dataclasses.replace(NOW, time_s=time_s, odom_stamp_s=pose_s or time_s)
    return now, time_s if seen_s is None else seen_s


def test_half_a_second_of_silence_stops_the_robot():
    """It goes on as soon as it sees again."""
    senses = Senses(10.0)
    for time_s, pose_s, expected in [(10.0, 10.0, True), (10.6, 10.0, False), (10.7, 10.65, True)]:
        now, seen_s = at(time_s, pose_s=pose_s)
        assert senses.check(now, seen_s, driving=True) is expected


@pytest.mark.parametrize(("driving", "code"), [(True, 102), (False, 202)])
def test_a_pose_that_stops_coming_ends_the_goal(driving, code):
    """With the controller's code when it drives, and the planner's when it has no path yet."""
    senses = Senses(10.0)
    now, seen_s = at(13.1, pose_s=10.0)
    assert senses.check(now, seen_s, driving=driving) == Finished(
        "aborted",
        code,
        "no pose of the robot on the map with a stamp less than 0.5 s from now for 3.1 s; "
        "is the robot running, and do the clocks agree?",
    )


def test_a_scan_that_stops_coming_ends_the_goal():
    """With the code that Nav2's controller has for a costmap that is too old."""
    senses = Senses(10.0)
    now, seen_s = at(13.1, seen_s=10.0)
    ended = senses.check(now, seen_s, driving=True)
    assert isinstance(ended, Finished)
    assert ended.error_code == 107


def test_a_stamp_from_the_future_is_not_trusted():
    """Clocks that differ would hide that nothing comes any more."""
    now, seen_s = at(10.0, pose_s=12.0)
    assert Senses(10.0).check(now, seen_s, driving=True) is False


def test_before_the_first_scan_was_placed_the_robot_waits():
    """And not for ever."""
    senses = Senses(10.0)
    assert senses.check(NOW, None, driving=False) is False
    late = dataclasses.replace(NOW, time_s=13.05, odom_stamp_s=13.05)
    assert isinstance(senses.check(late, None, driving=False), Finished)


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
