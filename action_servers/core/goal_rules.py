"""Every action of the servers: its type, what its goals may hold, and how far its feedback goes.

`bt-mission check` reads this table; the limits in it are those by which the servers refuse goals.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeAlias

from action_servers.core import goal_limits
from action_servers.core.limits import Limits
from action_servers.core.tuning import Tuning
from bt_mission.core.robot.model import RobotModel

FeedbackRanges: TypeAlias = Mapping[str, tuple[float, float]]
"""From where to where the numbers of a feedback can go, by their names."""

OVERSHOOT_DEG = 5.0
"""What a rotation may turn too far, and what odometry may be wrong by, with much to spare."""

OVERSHOOT_M = 0.1
"""The same for a way."""

_UNBOUNDED = (0.0, math.inf)


def _nothing(_goal: Any) -> None:
    return None


def _no_ranges(_goal: Any) -> FeedbackRanges:
    return {}


@dataclass(frozen=True, slots=True, kw_only=True)
class ActionRules:
    """What is known of the goals of one action before any is sent.

    Args:
        type: The full name of the action's type.
        limits: The limits of single fields, for a robot and the parameters of its servers.
        misfit: Why a goal, by its fields together, is aborted as soon as it is accepted, or None.
        feedback: The ranges of the feedback's numbers for a goal whose fields are all known.
    """

    type: str
    limits: Callable[[RobotModel, Tuning], Limits]
    misfit: Callable[[Any], str | None] = _nothing
    feedback: Callable[[Any], FeedbackRanges] = _no_ranges


def _around(target: float, slack: float) -> tuple[float, float]:
    """Return the range from 0 to a target of either sign, with some slack."""
    return min(0.0, target) - slack, max(0.0, target) + slack


def _turn_feedback(goal: Any) -> FeedbackRanges:
    turned = _around(goal.angle, OVERSHOOT_DEG)
    return {"current_angle": turned, "remaining_angle": turned}


def _spin_feedback(goal: Any) -> FeedbackRanges:
    return {"angular_distance_traveled": _around(goal.target_yaw, math.radians(OVERSHOOT_DEG))}


def _straight_feedback(goal: Any) -> FeedbackRanges:
    return {"distance_traveled": _around(abs(goal.target.x), OVERSHOOT_M)}


def _sweep_feedback(goal: Any) -> FeedbackRanges:
    return {
        "current_image": (0.0, goal.image_count),
        "current_angle": _around(goal.sweep_angle, OVERSHOOT_DEG),
    }


def _explore_forward_feedback(_goal: Any) -> FeedbackRanges:
    return {"current_distance_travelled": _UNBOUNDED, "closest_obstacle": _UNBOUNDED}


def _frontiers_feedback(_goal: Any) -> FeedbackRanges:
    return {"frontiers_left": _UNBOUNDED, "area_mapped": _UNBOUNDED}


def _colour_feedback(_goal: Any) -> FeedbackRanges:
    return {"share": (0.0, 1.0)}


def _recorded_feedback(_goal: Any) -> FeedbackRanges:
    return {"current_dist": _UNBOUNDED}


def _navigation_feedback(_goal: Any) -> FeedbackRanges:
    return {"distance_remaining": _UNBOUNDED, "number_of_recoveries": _UNBOUNDED}


def _through_poses_feedback(goal: Any) -> FeedbackRanges:
    return {
        **_navigation_feedback(goal),
        "number_of_poses_remaining": (1.0, max(1, len(goal.poses))),
    }


def _waypoints_feedback(goal: Any) -> FeedbackRanges:
    return {"current_waypoint": (0.0, max(0, len(goal.poses) - 1))}


def _fixed(limits: Limits) -> Callable[[RobotModel, Tuning], Limits]:
    return lambda _robot, _tuning: limits


def _tuned(limits: Callable[[Tuning], Limits]) -> Callable[[RobotModel, Tuning], Limits]:
    return lambda _robot, tuning: limits(tuning)


ACTIONS: Mapping[str, ActionRules] = {
    "move": ActionRules(type="bt_mission_interfaces/action/Move", limits=goal_limits.move_limits),
    "turn": ActionRules(
        type="bt_mission_interfaces/action/Turn",
        limits=goal_limits.turn_limits,
        feedback=_turn_feedback,
    ),
    "explore_forward": ActionRules(
        type="bt_mission_interfaces/action/ExploreForward",
        limits=goal_limits.explore_forward_limits,
        feedback=_explore_forward_feedback,
    ),
    "explore_frontiers": ActionRules(
        type="bt_mission_interfaces/action/ExploreFrontiers",
        limits=_fixed(goal_limits.EXPLORE_FRONTIERS),
        feedback=_frontiers_feedback,
    ),
    "camera_sweep": ActionRules(
        type="bt_mission_interfaces/action/CameraSweep",
        limits=_tuned(goal_limits.camera_sweep_limits),
        feedback=_sweep_feedback,
    ),
    "take_pictures": ActionRules(
        type="bt_mission_interfaces/action/TakePictures",
        limits=_tuned(goal_limits.take_pictures_limits),
    ),
    "find_colour": ActionRules(
        type="bt_mission_interfaces/action/FindColour",
        limits=_fixed(goal_limits.FIND_COLOUR),
        feedback=_colour_feedback,
    ),
    "record_distance": ActionRules(
        type="bt_mission_interfaces/action/RecordDistance",
        limits=_tuned(goal_limits.record_distance_limits),
        feedback=_recorded_feedback,
    ),
    "navigate_to_pose": ActionRules(
        type="nav2_msgs/action/NavigateToPose",
        limits=_fixed(()),
        misfit=goal_limits.pose_misfit,
        feedback=_navigation_feedback,
    ),
    "navigate_through_poses": ActionRules(
        type="nav2_msgs/action/NavigateThroughPoses",
        limits=_fixed(()),
        misfit=goal_limits.through_poses_misfit,
        feedback=_through_poses_feedback,
    ),
    "follow_waypoints": ActionRules(
        type="nav2_msgs/action/FollowWaypoints",
        limits=_fixed(()),
        misfit=goal_limits.waypoints_misfit,
        feedback=_waypoints_feedback,
    ),
    "spin": ActionRules(
        type="nav2_msgs/action/Spin",
        limits=_tuned(goal_limits.spin_limits),
        feedback=_spin_feedback,
    ),
    "backup": ActionRules(
        type="nav2_msgs/action/BackUp",
        limits=goal_limits.straight_limits,
        misfit=partial(goal_limits.straight_misfit, backwards=True),
        feedback=_straight_feedback,
    ),
    "drive_on_heading": ActionRules(
        type="nav2_msgs/action/DriveOnHeading",
        limits=goal_limits.straight_limits,
        misfit=partial(goal_limits.straight_misfit, backwards=False),
        feedback=_straight_feedback,
    ),
    "wait": ActionRules(type="nav2_msgs/action/Wait", limits=_fixed(goal_limits.WAIT)),
}
"""The rules of each action, by the name that the servers give it."""
