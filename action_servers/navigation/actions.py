"""The actions of Nav2 that drive on a map: from goals in its messages to maneuvers.

Feedback and results need no translation here: the maneuvers return Nav2's field names.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from action_servers.core.action import Action, FeedbackRanges
from action_servers.core.limits import UNBOUNDED
from action_servers.core.maneuver import ErrorCode, Fields, Observation, Refusal
from action_servers.navigation.navigate import NavigateToPose
from action_servers.navigation.path import NAVIGATION, NavigationTuning
from action_servers.navigation.surroundings import PLAN, Surroundings, ignore
from action_servers.navigation.waypoints import FollowWaypoints, NavigateThroughPoses
from bt_mission.base.geometry import Pose2D, composed, relative, yaw_of
from bt_mission.robots.model import RobotModel

CODES = (
    ErrorCode.TF_ERROR_WHILE_DRIVING,
    ErrorCode.FAILED_TO_MAKE_PROGRESS,
    ErrorCode.CONTROLLER_TIMED_OUT,
    ErrorCode.TF_ERROR_WHILE_PLANNING,
    ErrorCode.START_OUTSIDE_MAP,
    ErrorCode.GOAL_OUTSIDE_MAP,
    ErrorCode.START_OCCUPIED,
    ErrorCode.GOAL_OCCUPIED,
    ErrorCode.NO_VALID_PATH,
)
"""The codes of Nav2's planner and controller with which a drive on the map ends."""

_UNIT_TOLERANCE = 0.01

MOST_POSES = 1_000
"""Poses of a goal: each is checked and placed on the map between two control steps."""


def pose_misfit(goal: Any, _robot: RobotModel) -> str | None:
    """Return why a goal of `navigate_to_pose` is invalid, or None."""
    return None if goal.pose.header.frame_id else "the pose is missing, or its header.frame_id"


def waypoints_misfit(goal: Any) -> str | None:
    """Return why a goal of `follow_waypoints` is invalid, or None."""
    if not goal.poses:
        return "the list of poses is empty"
    too_many = poses_misfit(goal)
    if too_many is not None:
        return too_many
    last = len(goal.poses) - 1
    if goal.goal_index > last:
        return f"goal_index must be from 0 to {last}, got {goal.goal_index}"
    return None


def through_poses_misfit(goal: Any) -> str | None:
    """Return why a goal of `navigate_through_poses` is invalid, or None."""
    return poses_misfit(goal) if goal.poses else "poses must hold at least one pose"


def poses_misfit(goal: Any) -> str | None:
    """Return why there are too many poses in a goal, or None."""
    count = len(goal.poses)
    return None if count <= MOST_POSES else f"poses must be {MOST_POSES:,} or less, got {count:,}"


def navigation_feedback(_goal: Any) -> FeedbackRanges:
    """Return the ranges of a way that is driven."""
    return {"distance_remaining": UNBOUNDED, "number_of_recoveries": UNBOUNDED}


def through_poses_feedback(goal: Any) -> FeedbackRanges:
    """Return the ranges of a way, and of the poses on it."""
    poses = (1.0, max(1, len(goal.poses)))
    return {**navigation_feedback(goal), "number_of_poses_remaining": poses}


def plan_navigate_to_pose(
    goal: Any,
    now: Observation,
    robot: RobotModel,
    tuning: NavigationTuning = NAVIGATION,
    publish: Callable[[Fields], object] = ignore,
) -> NavigateToPose | Refusal:
    """Check a goal of NavigateToPose; a pose in another frame is moved to the map as of now."""
    if goal.behavior_tree:
        return _no_tree(goal.behavior_tree)
    pose = on_map(goal.pose, "pose", now)
    if isinstance(pose, Refusal):
        return pose
    return NavigateToPose(pose, robot, Surroundings(robot, tuning, publish))


def plan_follow_waypoints(
    goal: Any,
    now: Observation,
    robot: RobotModel,
    tuning: NavigationTuning = NAVIGATION,
    publish: Callable[[Fields], object] = ignore,
) -> FollowWaypoints | Refusal:
    """Check a goal of FollowWaypoints. An empty list is accepted and then aborted, as by Nav2."""
    poses = _poses_on_map(goal, now, waypoints_misfit if goal.poses else poses_misfit)
    if isinstance(poses, Refusal):
        return poses
    around = Surroundings(robot, tuning, publish)
    return FollowWaypoints(poses, robot, around, loops=goal.number_of_loops, first=goal.goal_index)


def plan_navigate_through_poses(
    goal: Any,
    now: Observation,
    robot: RobotModel,
    tuning: NavigationTuning = NAVIGATION,
    publish: Callable[[Fields], object] = ignore,
) -> NavigateThroughPoses | Refusal:
    """Check a goal of NavigateThroughPoses."""
    if goal.behavior_tree:
        return _no_tree(goal.behavior_tree)
    poses = _poses_on_map(goal, now, through_poses_misfit)
    if isinstance(poses, Refusal):
        return poses
    return NavigateThroughPoses(poses, robot, Surroundings(robot, tuning, publish))


def _no_tree(name: str) -> Refusal:
    return Refusal(
        f"behavior_tree must be empty, got '{name}': this server is no tree; run it on a Nav2 robot"
    )


def _poses_on_map(
    goal: Any, now: Observation, misfit: Callable[[Any], str | None]
) -> Sequence[Pose2D] | Refusal:
    too_many = poses_misfit(goal)
    if too_many is not None:
        return Refusal(too_many)
    poses: list[Pose2D] = []
    for index, stamped in enumerate(goal.poses):
        pose = on_map(stamped, f"poses[{index}]", now)
        if isinstance(pose, Refusal):
            return pose
        poses.append(pose)
    why = misfit(goal)
    return poses if why is None else Refusal(why)


def on_map(stamped: Any, name: str, now: Observation) -> Pose2D | Refusal:
    """Return the pose of a message on the map as of now, or a refusal; `name` is its field."""
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


NAVIGATE_TO_POSE = Action(
    name="navigate_to_pose",
    type="nav2_msgs/action/NavigateToPose",
    needs=("base", "scan", "odometry", "map"),
    example={"pose": [1.5, 0.0, 0.0]},
    plan=plan_navigate_to_pose,
    tuning=NAVIGATION,
    topic=PLAN,
    misfit=pose_misfit,
    codes=CODES,
    feedback=navigation_feedback,
)

NAVIGATE_THROUGH_POSES = Action(
    name="navigate_through_poses",
    type="nav2_msgs/action/NavigateThroughPoses",
    needs=("base", "scan", "odometry", "map"),
    example={"poses": [[1.0, 0.0, 0.0], [1.5, 0.5, 0.0]]},
    plan=plan_navigate_through_poses,
    tuning=NAVIGATION,
    topic=PLAN,
    misfit=lambda goal, _: through_poses_misfit(goal),
    codes=CODES,
    feedback=through_poses_feedback,
)

FOLLOW_WAYPOINTS = Action(
    name="follow_waypoints",
    type="nav2_msgs/action/FollowWaypoints",
    needs=("base", "scan", "odometry", "map"),
    example={"poses": [[1.0, 0.0, 0.0], [1.5, 0.5, 0.0]]},
    plan=plan_follow_waypoints,
    tuning=NAVIGATION,
    topic=PLAN,
    misfit=lambda goal, _: waypoints_misfit(goal),
    codes=(ErrorCode.WAYPOINTS_UNKNOWN,),
    feedback=lambda goal: {"current_waypoint": (0.0, max(0, len(goal.poses) - 1))},
)
