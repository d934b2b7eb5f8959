"""What stands between a running goal and a base that drives on: the stop service, a lost scan."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bt_mission_interfaces.action import CameraSweep, ExploreForward, Move, Turn
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import Point, PoseStamped
from nav2_msgs.action import (
    BackUp,
    DriveOnHeading,
    FollowWaypoints,
    NavigateThroughPoses,
    NavigateToPose,
    Spin,
)
from safety_rig import Rig
from safety_trials import Stop, stopped

WORLD = "empty_arena"
ALLOWED = Duration(sec=30)
FULL_SPEED = 0.26


def _pose(x: float, y: float) -> PoseStamped:
    message = PoseStamped()
    message.header.frame_id = "map"
    message.pose.position.x, message.pose.position.y = x, y
    message.pose.orientation.w = 1.0
    return message


GOALS: dict[str, tuple[Any, Callable[[], Any]]] = {
    "explore_forward": (
        ExploreForward,
        lambda: ExploreForward.Goal(fwd_velocity=FULL_SPEED, stopping_distance=0.3),
    ),
    "turn": (Turn, lambda: Turn.Goal(angle=720.0, angular_velocity=1.5)),
    "camera_sweep": (CameraSweep, lambda: CameraSweep.Goal(sweep_angle=180.0, image_count=2)),
    "move": (Move, lambda: Move.Goal(secs=8, linear_velocity=0.2, angular_velocity=0.5)),
    "navigate_to_pose": (NavigateToPose, lambda: NavigateToPose.Goal(pose=_pose(1.4, 0.3))),
    "navigate_through_poses": (
        NavigateThroughPoses,
        lambda: NavigateThroughPoses.Goal(poses=[_pose(1.4, 0.3), _pose(0.0, 0.0)]),
    ),
    "follow_waypoints": (
        FollowWaypoints,
        lambda: FollowWaypoints.Goal(poses=[_pose(1.5, 0.5), _pose(0.0, 0.0)]),
    ),
    "spin": (Spin, lambda: Spin.Goal(target_yaw=6.0, time_allowance=ALLOWED)),
    "backup": (
        BackUp,
        lambda: BackUp.Goal(target=Point(x=-1.5), speed=0.2, time_allowance=ALLOWED),
    ),
    "drive_on_heading": (
        DriveOnHeading,
        lambda: DriveOnHeading.Goal(target=Point(x=1.5), speed=FULL_SPEED, time_allowance=ALLOWED),
    ),
}
"""Every action that drives, and a goal of it that takes several seconds from the middle."""


def by_service(name: str) -> Stop:
    """Call the stop service in the midst of an action."""
    return _stopped(name, lambda rig: rig.call_stop())


def by_lost_scan(name: str) -> Stop:
    """Let the lidar fall silent in the midst of an action."""
    return _stopped(name, lambda rig: rig.silence("scan"))


def _stopped(name: str, happening: Callable[[Rig], Any]) -> Stop:
    action_type, goal = GOALS[name]
    with Rig(WORLD, seed=1) as rig:
        rig.prepare(name, action_type)
        rig.wait(0.5)
        return stopped(rig, name, goal(), happening)
