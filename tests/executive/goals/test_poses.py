"""Poses that goals name."""

import math
from typing import Any

import pytest
from bt_mission_interfaces.action import Turn
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import FollowWaypoints, NavigateToPose

from bt_mission.executive.goals.poses import poses_of


def stamped(x: float, y: float, yaw: float, frame: str = "map") -> PoseStamped:
    """A pose."""
    pose = PoseStamped()
    pose.header.frame_id = frame
    pose.pose.position.x, pose.pose.position.y = x, y
    pose.pose.orientation.z, pose.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return pose


TWO = [(1.0, 0.0, 0.0, "map"), (0.0, 1.0, 0.0, "map")]


@pytest.mark.parametrize(
    ("goal", "poses"),
    [
        (NavigateToPose.Goal(pose=stamped(1.0, 2.0, 0.5, "odom")), [(1.0, 2.0, 0.5, "odom")]),
        (FollowWaypoints.Goal(poses=[stamped(*pose) for pose in TWO]), TWO),
        (Turn.Goal(), []),
        (None, []),
    ],
    ids=["one", "many, in their order", "none", "no message"],
)
def test_the_poses_of_a_goal(goal: Any, poses: list[tuple[float, float, float, str]]) -> None:
    """With direction and frame."""
    results = [(pose.x, pose.y, round(pose.yaw, 9), pose.frame) for pose in poses_of(goal)]
    assert results == poses
