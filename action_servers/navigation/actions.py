"""From goals in Nav2's messages to maneuvers.

Feedback and results need no translation here: the maneuvers answer with Nav2's field names.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import FollowWaypoints as FollowWaypointsAction
from nav2_msgs.action import NavigateThroughPoses as NavigateThroughPosesAction
from nav2_msgs.action import NavigateToPose as NavigateToPoseAction

from action_servers.core.checks import refusal, stale
from action_servers.core.goal_limits import (
    poses_misfit,
    through_poses_misfit,
    waypoints_misfit,
)
from action_servers.core.maneuver import Observation, Refusal
from action_servers.core.tuning import NAVIGATION, NavigationTuning
from action_servers.navigation.navigate import NavigateToPose
from action_servers.navigation.senses import missing
from action_servers.navigation.surroundings import Surroundings
from action_servers.navigation.through_poses import NavigateThroughPoses
from action_servers.navigation.waypoints import FollowWaypoints
from bt_mission.core.geometry import Pose2D, composed, relative, yaw_of
from bt_mission.core.robot.model import RobotModel

_UNIT_TOLERANCE = 0.01


def plan_navigate_to_pose(
    goal: NavigateToPoseAction.Goal,
    now: Observation,
    robot: RobotModel,
    tuning: NavigationTuning = NAVIGATION,
) -> NavigateToPose | Refusal:
    """Check a goal of NavigateToPose; a pose in another frame is moved to the map as of now."""
    if goal.behavior_tree:
        return _no_tree(goal.behavior_tree)
    unready = refusal(missing(now), unready=stale(now))
    if unready is not None:
        return unready
    pose = _on_map(goal.pose, "pose", now)
    if isinstance(pose, Refusal):
        return pose
    return NavigateToPose(pose, robot, Surroundings(robot, tuning))


def plan_follow_waypoints(
    goal: FollowWaypointsAction.Goal,
    now: Observation,
    robot: RobotModel,
    tuning: NavigationTuning = NAVIGATION,
) -> FollowWaypoints | Refusal:
    """Check a goal of FollowWaypoints. An empty list is accepted and then aborted, as by Nav2."""
    unready = refusal(poses_misfit(goal), missing(now), unready=stale(now))
    if unready is not None:
        return unready
    poses = _all_on_map(goal.poses, now)
    if isinstance(poses, Refusal):
        return poses
    misfit = waypoints_misfit(goal) if poses else None
    if misfit is not None:
        return Refusal(misfit)
    return FollowWaypoints(
        poses, robot, loops=goal.number_of_loops, first=goal.goal_index, tuning=tuning
    )


def plan_navigate_through_poses(
    goal: NavigateThroughPosesAction.Goal,
    now: Observation,
    robot: RobotModel,
    tuning: NavigationTuning = NAVIGATION,
) -> NavigateThroughPoses | Refusal:
    """Check a goal of NavigateThroughPoses."""
    if goal.behavior_tree:
        return _no_tree(goal.behavior_tree)
    unready = refusal(poses_misfit(goal), missing(now), unready=stale(now))
    if unready is not None:
        return unready
    poses = _all_on_map(goal.poses, now)
    if isinstance(poses, Refusal):
        return poses
    misfit = through_poses_misfit(goal)
    if misfit is not None:
        return Refusal(misfit)
    return NavigateThroughPoses(poses, robot, Surroundings(robot, tuning))


def _no_tree(name: str) -> Refusal:
    return Refusal(
        f"behavior_tree must be empty, got '{name}': this server is no tree; run it on a Nav2 robot"
    )


def _all_on_map(poses: Sequence[PoseStamped], now: Observation) -> list[Pose2D] | Refusal:
    found: list[Pose2D] = []
    for index, stamped in enumerate(poses):
        pose = _on_map(stamped, f"poses[{index}]", now)
        if isinstance(pose, Refusal):
            return pose
        found.append(pose)
    return found


def _on_map(stamped: PoseStamped, name: str, now: Observation) -> Pose2D | Refusal:
    position, turn = stamped.pose.position, stamped.pose.orientation
    parts = (position.x, position.y, position.z, turn.x, turn.y, turn.z, turn.w)
    if not all(math.isfinite(part) for part in parts):
        return Refusal(f"{name} must hold finite numbers, got {', '.join(map(str, parts))}")
    norm = math.hypot(turn.x, turn.y, turn.z, turn.w)
    if abs(norm - 1.0) > _UNIT_TOLERANCE:
        return Refusal(f"{name}.pose.orientation must have length 1, got {norm:g}")
    frame = stamped.header.frame_id
    pose = Pose2D(position.x, position.y, yaw_of(turn))
    if frame in {"", "map"}:
        return pose
    if frame == "odom":
        if now.map_pose is None or now.odom is None:
            return Refusal(f"{name} is given in odom, whose place on the map is not known yet")
        return composed(now.map_pose, relative(now.odom, pose))
    if now.frame_on_map is None:
        return Refusal(f"{name}.header.frame_id must be one of map, odom, got '{frame}'")
    origin = now.frame_on_map(frame)
    if isinstance(origin, Refusal):
        return Refusal(f"{name}: {origin.reason}")
    return composed(origin, pose)
