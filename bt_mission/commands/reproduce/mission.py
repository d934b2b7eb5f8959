"""The mission of a recorded run: its own file, or else the goals that were sent, as a mission."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import cv2
import numpy as np

from bt_mission.base.geometry import yaw_of
from bt_mission.cdr.decoder import DecodedMessage
from bt_mission.commands.reproduce.evidence import Evidence
from bt_mission.commands.reproduce.silences import IDLE_S, died_at, spans_where
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.recording.goal_lives import RecordedGoal

LONGER = 3.0
SHORTEST_LIMIT_S = 30.0
PAUSE_S = 0.12
"""A shorter time between two goals is the mission's own."""
WAY_M = 0.15
"""A path without goals becomes waypoints from which it is not farther away."""
NEAREST_M = 0.4
USUAL_GAP_M = 0.3
PLACES = ("navigate_to_pose", "navigate_through_poses", "follow_waypoints")
"""Their goals are on the map, whose place is unknown if nothing localises the robot."""
STILL_S, STILL_M_S, STILL_RAD_S = 0.5, 0.03, 0.05
"""A robot that moves less in this time stands still."""
REST_S = 1.0
"""A shorter rest is a part of the way."""
BACK_S = 0.1
"""Steps back along a path, s, to a place where the robot fits."""


Fits = Callable[[float, float], bool]
"""Does a path lead the robot to a place of the traced world, m?"""


def mission_data(name: str, evidence: Evidence, robot: str, fits: Fits) -> dict[str, Any]:
    """Return a mission that sends the recorded goals again, at the same distances of time.

    A goal that the recording does not have is where the robot went, as far as it fits there:
    something may have moved it where no planner sends it.
    """
    goals = list(evidence.goals)
    steps = _steps(evidence, goals, fits) if goals else _way(evidence, fits)
    return {
        "mission": name,
        "description": "The goals of a recorded run."
        if goals
        else "The path of a recorded run, as waypoints.",
        "world": "world.yaml",
        "robot": robot,
        "tree": steps[0] if len(steps) == 1 else {"sequence": steps},
    }


def _steps(evidence: Evidence, goals: Sequence[RecordedGoal], fits: Fits) -> list[dict[str, Any]]:
    steps: list[dict[str, Any]] = []
    names: dict[str, int] = {}
    groups = _groups(evidence, goals)
    end = evidence.since_start(goals[0].start_ns)
    for number, group in enumerate(groups):
        begin = evidence.since_start(group[0].start_ns)
        if begin - end > PAUSE_S:
            steps.append({"wait": round(begin - end, 2)})
        is_last = number == len(groups) - 1
        nodes = [_node(evidence, goal, names, fits, is_last=is_last) for goal in group]
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


def _groups(evidence: Evidence, goals: Sequence[RecordedGoal]) -> list[list[RecordedGoal]]:
    """Return the goals that were under way at the same time together."""
    groups: list[list[RecordedGoal]] = []
    end = -math.inf
    for goal in goals:
        if groups and evidence.since_start(goal.start_ns) < end - 0.3:
            groups[-1].append(goal)
        else:
            groups.append([goal])
        end = max(end, _end(evidence, goal))
    return groups


def _end(evidence: Evidence, goal: RecordedGoal) -> float:
    """Return when the client was done with a goal: at its end, or when it gave it up."""
    if goal.cancels and not goal.was_refused and goal.result_ns is None:
        return evidence.since_start(goal.cancels[-1].asked_ns)
    return evidence.end_s if goal.end_ns is None else evidence.since_start(goal.end_ns)


def _node(
    evidence: Evidence, goal: RecordedGoal, names: dict[str, int], fits: Fits, *, is_last: bool
) -> dict[str, Any]:
    kind = _kind(goal)
    names[goal.action] = names.get(goal.action, 0) + 1
    name = f"{kind or goal.action.strip('/')} {names[goal.action]}"
    limit, is_canceled = _limit(evidence, goal)
    is_known = goal.requested_ns is not None and (kind not in PLACES or evidence.is_localised)
    values = _values(goal.values) if is_known else _guessed(evidence, goal, kind, fits)
    if kind and values is not None:
        node = {kind: values, "name": name, "timeout": limit}
    else:
        node = _instead(evidence, goal, name, fits)
    if (is_canceled or goal.outcome != "succeeded") and not is_last:
        return {"force": "success", "do": node}
    return node


def _kind(goal: RecordedGoal) -> str:
    """Return the kind of node of an action, whatever its namespace; empty if it has none."""
    last = goal.action.rpartition("/")[2]
    return next(
        (
            kind
            for kind, known in ACTION_NAMES.items()
            if known.name.strip("/") == last and known.type == goal.type_name
        ),
        "",
    )


def _instead(evidence: Evidence, goal: RecordedGoal, name: str, fits: Fits) -> dict[str, Any]:
    """Return the path during a goal that the stage has no server for, or else its time."""
    begin, end = evidence.since_start(goal.start_ns), _end(evidence, goal)
    poses = way_between(evidence, begin, end, fits)
    is_near = len(poses) == 1 and math.dist(poses[0][:2], _place(evidence, begin)) < WAY_M
    if is_near or not poses:
        return {"wait": round(max(end - begin, 0.05), 2), "name": name}
    timeout = round(max(SHORTEST_LIMIT_S, LONGER * (end - begin)), 1)
    return {"navigate_through_poses": {"poses": poses}, "name": name, "timeout": timeout}


def _place(evidence: Evidence, time_s: float) -> tuple[float, float]:
    pose = evidence.track.pose(time_s)
    return pose.x, pose.y


def _limit(evidence: Evidence, goal: RecordedGoal) -> tuple[float, bool]:
    """Return the time-out of a goal, s, and whether its client canceled it at that time."""
    begin = goal.answered_ns or goal.start_ns
    died = died_at(evidence, goal)
    canceled = evidence.since_start(goal.cancels[0].asked_ns) if goal.cancels else math.inf
    if goal.cancels and goal.answered_ns is not None and (died is None or died > canceled + IDLE_S):
        return max(round((goal.cancels[0].asked_ns - begin) / 1e9, 2), 0.05), True
    if goal.requested_ns is None and goal.outcome == "canceled":
        return max(round(_end(evidence, goal) - evidence.since_start(begin), 2), 0.05), True
    took = _end(evidence, goal) - evidence.since_start(begin)
    return round(max(SHORTEST_LIMIT_S, LONGER * took), 1), False


def _guessed(
    evidence: Evidence, goal: RecordedGoal, kind: str, fits: Fits
) -> dict[str, Any] | None:
    """Return a goal that the recording does not have, by what the robot did; None if unknown."""
    begin, end = evidence.since_start(goal.start_ns), _end(evidence, goal)
    first, last = evidence.track.pose(begin), evidence.track.pose(end)
    turned = float(np.diff(evidence.track.at(np.array([begin, end]))[2])[0])
    driven = round(math.dist((first.x, first.y), (last.x, last.y)), 3)
    table = evidence.odometry
    speeds = np.abs(table[(table[:, 0] >= begin) & (table[:, 0] <= end), 4])
    speed = max(round(float(np.percentile(speeds, 80)), 3) if len(speeds) else 0.1, 0.02)
    ends = [
        [round(pose.x, 3), round(pose.y, 3), round(math.degrees(pose.yaw), 1)]
        for time, pose in evidence.plan_ends
        if begin - 0.5 <= time <= end and evidence.is_localised
    ]
    ends = [each for each in ends if fits(*each[:2])]
    if not ends and (kind in PLACES[1:] or (kind in PLACES and not fits(last.x, last.y))):
        return None
    ends = ends or [[round(last.x, 3), round(last.y, 3), round(math.degrees(last.yaw), 1)]]
    match kind:
        case "navigate_to_pose":
            return {"pose": ends[-1]}
        case "navigate_through_poses" | "follow_waypoints":
            return {"poses": ends}
        case "turn":
            return {"angle": round(math.degrees(turned), 1)}
        case "spin":
            return {"target_yaw": round(turned, 3)}
        case "explore_forward":
            return {"fwd_velocity": speed, "stopping_distance": USUAL_GAP_M}
        case "drive_on_heading" | "back_up":
            return {"target": {"x": driven}, "speed": speed}
    return None


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


def _way(evidence: Evidence, fits: Fits) -> list[dict[str, Any]]:
    """Return waypoints along the path of a run that has no goals, and its rests."""
    steps: list[dict[str, Any]] = []
    rest_since = 0.0
    for number, (begin, end) in enumerate(_drives(evidence), 1):
        if begin - rest_since > PAUSE_S:
            steps.append({"wait": round(begin - rest_since, 2)})
        rest_since = end
        poses = way_between(evidence, begin, end, fits)
        if not poses:
            steps.append({"wait": round(end - begin, 2)})
            continue
        steps.append(
            {
                "navigate_through_poses": {"poses": poses},
                "name": f"way {number}",
                "timeout": round(max(SHORTEST_LIMIT_S, LONGER * (end - begin)), 1),
            }
        )
    return steps or [{"wait": round(max(evidence.end_s, STILL_S), 2)}]


def _drives(evidence: Evidence) -> list[tuple[float, float]]:
    """Return the spans in which the robot drives, with longer rests between them."""
    times = np.arange(0.0, max(evidence.end_s, STILL_S), STILL_S / 5)
    ahead, aside, turn = evidence.track.motion(times, STILL_S)
    drives = (np.hypot(ahead, aside) > STILL_M_S) | (np.abs(turn) > STILL_RAD_S)
    return spans_where(times, drives, 2, gap_s=REST_S)


def way_between(evidence: Evidence, begin: float, end: float, fits: Fits) -> list[list[float]]:
    """Return poses from which the path between two times is not far away.

    The last is its end, or the last place before it where the robot fits; none if it fits nowhere.
    """
    track = evidence.track
    ends = np.arange(end, begin, -BACK_S)
    end = next((float(time) for time in ends if fits(*_place(evidence, time))), begin)
    inside = (track.times >= begin) & (track.times <= end)
    points = np.column_stack((track.x[inside], track.y[inside])).astype(np.float32)
    corners: Any = cv2.approxPolyDP(points[:, None], WAY_M, closed=False) if len(points) else []
    poses: list[list[float]] = []
    places = [(float(x), float(y)) for ((x, y),) in corners]
    for (x, y), (next_x, next_y) in pairwise(places):
        if poses:
            poses[-1][2] = round(math.degrees(math.atan2(next_y - y, next_x - x)), 1)
        if not poses or math.dist(poses[-1][:2], (next_x, next_y)) > NEAREST_M:
            poses.append([round(next_x, 3), round(next_y, 3), 0.0])
    pose = track.pose(end)
    last = [round(pose.x, 3), round(pose.y, 3), round(math.degrees(pose.yaw), 1)]
    way = [*(each for each in poses if math.dist(each[:2], last[:2]) > WAY_M), last]
    return [each for each in way if fits(*each[:2])]
