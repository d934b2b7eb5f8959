import math

import pytest

from action_servers.navigation.senses import PoseHistory
from bt_mission.core.geometry import Pose2D


def test_nothing_is_known_without_a_pose():
    """An empty history has no answer."""
    assert PoseHistory().at(1.0) is None


def test_between_two_poses_the_share_of_time_is_the_share_of_way():
    """Half way in time is half way in place and angle, the short way round."""
    history = PoseHistory()
    history.remember(1.0, Pose2D(0.0, 0.0, math.pi - 0.1))
    history.remember(2.0, Pose2D(1.0, 2.0, -math.pi + 0.1))
    pose = history.at(1.5)
    assert pose is not None
    assert (pose.x, pose.y) == (0.5, 1.0)
    assert abs(math.remainder(pose.yaw - math.pi, math.tau)) < 1e-9


@pytest.mark.parametrize(
    ("stamp_s", "known"), [(0.8, False), (0.9, True), (1.1, True), (1.2, False)]
)
def test_a_pose_is_good_for_a_moment_before_and_after(stamp_s, known):
    """0.15 s: a scan that comes just before the pose of its time can be placed."""
    history = PoseHistory()
    history.remember(1.0, Pose2D(3.0, 0.0, 0.0))
    assert (history.at(stamp_s) is not None) is known


def test_what_is_older_than_a_second_is_forgotten():
    """A scan from then has no place any more."""
    history = PoseHistory()
    for stamp_s in (1.0, 2.0, 3.0):
        history.remember(stamp_s, Pose2D(stamp_s, 0.0, 0.0))
    assert history.at(1.5) is None
    assert history.at(2.5) == Pose2D(2.5, 0.0, 0.0)


def test_a_clock_that_is_set_back_begins_anew():
    """Poses of a future that is none any more are dropped."""
    history = PoseHistory()
    history.remember(10.0, Pose2D(1.0, 0.0, 0.0))
    history.remember(5.0, Pose2D(2.0, 0.0, 0.0))
    assert history.at(5.0) == Pose2D(2.0, 0.0, 0.0)
    assert history.at(10.0) is None
