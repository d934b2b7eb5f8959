"""Poses that goals name."""

import math

import pytest
from bt_mission_interfaces.action import Turn
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import FollowWaypoints, NavigateToPose

from bt_mission.goals.poses import NamedPose, poses_of


def stamped(x: float, y: float, yaw: float, frame: str = "map") -> PoseStamped:
    """A pose."""
    pose = PoseStamped()
    pose.header.frame_id = frame
    pose.pose.position.x, pose.pose.position.y = x, y
    pose.pose.orientation.z, pose.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return pose


def test_one_pose():
    """With its direction and its frame."""
    (place,) = poses_of(NavigateToPose.Goal(pose=stamped(1.0, 2.0, 0.5, "odom")))
    assert (place.x, place.y, place.frame) == (1.0, 2.0, "odom")
    assert place.yaw == pytest.approx(0.5)


def test_many_poses():
    """In their order."""
    goal = FollowWaypoints.Goal(poses=[stamped(1.0, 0.0, 0.0), stamped(0.0, 1.0, 0.0)])
    assert poses_of(goal) == [NamedPose(1.0, 0.0, 0.0, "map"), NamedPose(0.0, 1.0, 0.0, "map")]


def test_other_goals_name_none():
    """Nor does what is no message."""
    assert poses_of(Turn.Goal()) == []
    assert poses_of(None) == []
