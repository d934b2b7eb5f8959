"""The mission of a recorded run: its own file, or else the goals that were sent, as a mission."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import cv2
import numpy as np

from bt_mission.core.cdr.decoder import DecodedMessage
from bt_mission.core.geometry import yaw_of
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.reproducing.evidence import Evidence
from bt_mission.reproducing.goals import SUCCEEDED, GoalTrace
from bt_mission.reproducing.silences import died_at

LONGER = 3.0
SHORTEST_LIMIT_S = 30.0
PAUSE_S = 0.12
"""A shorter time between two goals is the mission's own."""
WAY_M = 0.15
"""A path without goals becomes waypoints from which it is not farther away."""
NEAREST_M = 0.4


def mission_data(name: str, evidence: Evidence, robot: str) -> dict[str, Any]:
    """Return a mission that sends the recorded goals again, at the same distances of time."""
    goals = list(evidence.goals)
    steps = _steps(evidence, goals) if goals else _way(evidence)
    return {
        "mission": name,
        "description": "The goals of a recorded run."
        if goals
        else "The path of a recorded run, as waypoints.",
        "world": "world.yaml",
        "robot": robot,
        "tree": steps[0] if len(steps) == 1 else {"sequence": steps},
    }


def _steps(evidence: Evidence, goals: Sequence[GoalTrace]) -> list[dict[str, Any]]:
    steps: list[dict[str, Any]] = []
    names: dict[str, int] = {}
    groups = _groups(evidence, goals)
    end = evidence.since_start(goals[0].start_ns)
    for number, group in enumerate(groups):
        begin = evidence.since_start(group[0].start_ns)
        if begin - end > PAUSE_S:
            steps.append({"wait": round(begin - end, 2)})
        is_last = number == len(groups) - 1
        nodes = [_node(evidence, goal, names, is_last=is_last) for goal in group]
        if len(nodes) == 1:
            steps.append(nodes[0])
        else:
            branches = []
            for goal, node in zip(group, nodes, strict=True):
                later = evidence.since_start(goal.start_ns) - begin
                wait = [{"wait": round(later, 2)}] if later > 0.03 else []
                branches.append({"sequence": [*wait, node]} if wait else node)
            steps.append({"parallel": branches, "fail_when": "impossible", "rest": "finish"})
        end = max(_end(evidence, goal) for goal in group)
    return steps


def _groups(evidence: Evidence, goals: Sequence[GoalTrace]) -> list[list[GoalTrace]]:
    """Return the goals that were under way at the same time together."""
    groups: list[list[GoalTrace]] = []
    end = -math.inf
    for goal in goals:
        if groups and evidence.since_start(goal.start_ns) < end - 0.3:
            groups[-1].append(goal)
        else:
            groups.append([goal])
        end = max(end, _end(evidence, goal))
    return groups


def _end(evidence: Evidence, goal: GoalTrace) -> float:
    """Return when the client was done with a goal: at its end, or when it gave it up."""
    if goal.cancels and not goal.is_rejected and goal.ended_ns is None:
        return evidence.since_start(goal.cancels[-1].asked_ns)
    return evidence.end_s if goal.end_ns is None else evidence.since_start(goal.end_ns)


def _node(
    evidence: Evidence, goal: GoalTrace, names: dict[str, int], *, is_last: bool
) -> dict[str, Any]:
    short = next(
        (
            kind
            for kind, known in ACTION_NAMES.items()
            if known.name.strip("/") == goal.action.strip("/") and known.type == goal.type_name
        ),
        None,
    )
    names[goal.action] = names.get(goal.action, 0) + 1
    values = _values(goal.values) if goal.is_introspected else _guessed(evidence, goal)
    node: dict[str, Any]
    if short is not None:
        node = {short: values}
    else:
        node = {"action": {"name": goal.action, "type": goal.type_name, "goal": values}}
    node["name"] = f"{short or goal.action.strip('/')} {names[goal.action]}"
    limit, is_canceled = _limit(evidence, goal)
    node["timeout"] = limit
    if (is_canceled or goal.outcome != SUCCEEDED) and not is_last:
        return {"force": "success", "do": node}
    return node


def _limit(evidence: Evidence, goal: GoalTrace) -> tuple[float, bool]:
    """Return the time-out of a goal, s, and whether its client canceled it at that time."""
    begin = goal.answered_ns or goal.start_ns
    died = died_at(evidence, goal)
    canceled = evidence.since_start(goal.cancels[0].asked_ns) if goal.cancels else math.inf
    if goal.cancels and goal.is_answered and (died is None or died > canceled - 0.3):
        return max(round((goal.cancels[0].asked_ns - begin) / 1e9, 2), 0.05), True
    took = _end(evidence, goal) - evidence.since_start(begin)
    return round(max(SHORTEST_LIMIT_S, LONGER * took), 1), False


def _guessed(evidence: Evidence, goal: GoalTrace) -> dict[str, Any]:
    """Return the goal of navigation where the recording has none: the end of its plan or path."""
    begin, end = evidence.since_start(goal.start_ns), _end(evidence, goal)
    ends = [pose for time, pose in evidence.plan_ends if begin - 0.5 <= time <= end]
    pose = ends[-1] if ends else evidence.track.pose(end)
    return {"pose": [round(pose.x, 3), round(pose.y, 3), round(math.degrees(pose.yaw), 1)]}


def _values(message: Mapping[str, Any]) -> dict[str, Any]:
    """Return a goal as a mission writes it: poses of the map as x, y and degrees, no defaults."""
    values: dict[str, Any] = {}
    for name, value in message.items():
        written = _value(value)
        if written not in ("", 0, 0.0, [], {}, None, False):
            values[name] = written
    return values


def _value(value: Any) -> Any:
    if isinstance(value, DecodedMessage):
        pose = _pose(value)
        return pose if pose is not None else _values(value)
    if isinstance(value, np.ndarray):
        return [_value(item) for item in value.tolist()]
    if isinstance(value, list | tuple):
        return [_value(item) for item in value]
    if isinstance(value, float):
        return round(value, 6)
    if isinstance(value, bytes):
        return list(value)
    return value


def _pose(message: DecodedMessage) -> list[float] | None:
    """Return a stamped pose on the map in short; None for another message."""
    if set(message) != {"header", "pose"} or message["header"].frame_id.strip("/") != "map":
        return None
    at = message["pose"].position
    yaw = yaw_of(message["pose"].orientation)
    return [round(at.x, 4), round(at.y, 4), round(math.degrees(yaw), 2)]


def _way(evidence: Evidence) -> list[dict[str, Any]]:
    """Return waypoints along the path of a run that has no goals."""
    track = evidence.track
    points = np.column_stack((track.x, track.y)).astype(np.float32)
    corners: Any = cv2.approxPolyDP(points[:, None], WAY_M, closed=False)
    end = track.pose(evidence.end_s)
    poses: list[list[float]] = []
    for (x, y), (next_x, next_y) in pairwise(corners[:, 0].tolist()):
        yaw = math.degrees(math.atan2(next_y - y, next_x - x))
        if poses:
            poses[-1][2] = round(yaw, 1)
        if not poses or math.dist(poses[-1][:2], (next_x, next_y)) > NEAREST_M:
            poses.append([round(next_x, 3), round(next_y, 3), 0.0])
    last = [round(end.x, 3), round(end.y, 3), round(math.degrees(end.yaw), 1)]
    poses = [*(pose for pose in poses if math.dist(pose[:2], last[:2]) > WAY_M), last]
    return [
        {
            "navigate_through_poses": {"poses": poses},
            "name": "the way",
            "timeout": round(max(SHORTEST_LIMIT_S, LONGER * evidence.end_s), 1),
        }
    ]
