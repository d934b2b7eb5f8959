"""A mission's state as JSON for the page: numbers are finite, times are seconds since its start.

Every text is escaped as for a terminal, so that none can hide or reverse its neighbours. The page
prevents markup: it writes text as text only.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from py_trees.common import Status

from bt_mission.base.stamps import NS
from bt_mission.base.text import escape_control
from bt_mission.executive.events.events import GoalChanged, RequirementChanged, RunStarted
from bt_mission.executive.events.log import LogEntry
from bt_mission.executive.events.messages import Map
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.executive.events.robot_state import RobotState

STATUS_CODES = {Status.INVALID: 0, Status.RUNNING: 1, Status.SUCCESS: 2, Status.FAILURE: 3}

OCCUPIED = 50
"""Cells of a map from this value on, of 100, are walls."""

MOST_TRAIL_POINTS = 1_000


def shown(value: Any) -> Any:
    """Return a value with all texts in it escaped and all numbers finite, or None."""
    match value:
        case str():
            return escape_control(value)
        case float():
            return value if math.isfinite(value) else None
        case dict():
            return {shown(key): shown(item) for key, item in value.items()}
        case list() | tuple():
            return [shown(item) for item in value]
    return value


def tree(started: RunStarted) -> dict[str, Any]:
    """Return a tree: name, class and parent's index of each node."""
    nodes = [(node.name, node.kind, node.parent, node.path) for node in started.nodes]
    facts = {"run": started.run, "mission": started.mission, "nodes": nodes}
    return {**shown(facts), "start": started.time_ns / NS}


def node(mission: MissionState, index: int) -> list[Any]:
    """Return the state of a node: status, message, start, running time, and progress."""
    assert mission.tree is not None, "nodes are those of a tree"
    current = mission.current(index)
    since_ns, ran_ns = current.time_ns, current.ran_ns
    progress = mission.progress.get(index) if index in mission.running else None
    return [
        index,
        STATUS_CODES[current.status],
        escape_control(current.message),
        None if since_ns is None else (since_ns - mission.tree.time_ns) / NS,
        None if ran_ns is None else ran_ns / NS,
        None
        if progress is None or not progress.limit
        else shown([progress.label, progress.value, progress.limit]),
    ]


def node_details(mission: MissionState, index: int) -> dict[str, Any] | None:
    """Return the details of a node, and its ends; None for an unknown node."""
    if mission.tree is None or not 0 <= index < len(mission.tree.nodes):
        return None
    start_ns = mission.tree.time_ns
    ends = [
        [
            STATUS_CODES[end.status],
            None if end.time_ns is None else (end.time_ns - start_ns) / NS,
            None if end.ran_ns is None else end.ran_ns / NS,
            end.message,
        ]
        for end in reversed(mission.ends[index])
    ]
    facts: dict[str, Any] = shown(
        {"index": index, "asked": mission.details(index), "ends": ends},
    )
    return facts


def goal(goal: GoalChanged, changed_ns: int, start_ns: int) -> list[Any]:
    """Return a goal: its id, action, owner, state, when it was sent, and when it last changed."""
    sent_s, changed_s = (goal.sent_ns - start_ns) / NS, (changed_ns - start_ns) / NS
    cells: list[Any] = shown([goal.id, goal.action, goal.owner, goal.state, sent_s, changed_s])
    return cells


def requirement(requirement: RequirementChanged) -> dict[str, Any]:
    """Return the result of a requirement."""
    facts: dict[str, Any] = shown(
        {
            "name": requirement.name,
            "requirement": requirement.requirement,
            "verdict": requirement.verdict,
            "margin": requirement.margin,
            "unit": requirement.unit,
            "at": requirement.at,
            "why": "; ".join(filter(None, (requirement.why, *requirement.sources))),
        }
    )
    return facts


def log_entry(entry: LogEntry, start_ns: int) -> list[Any]:
    """Return a line of the log: its time, status, name and text."""
    status = None if entry.status is None else STATUS_CODES[entry.status]
    cells: list[Any] = shown([(entry.time_ns - start_ns) / NS, status, entry.name, entry.text])
    return cells


def _pose(robot: RobotState) -> Any:
    pose = robot.pose
    return None if pose is None else shown([pose.x, pose.y, pose.yaw])


def _scan(robot: RobotState) -> list[int]:
    """The points of the lidar, x and y in turn, cm."""
    places = np.asarray(robot.scan_points(), np.float64).reshape(-1, 2)
    finite = places[np.isfinite(places).all(axis=1)]
    rounded: list[int] = (finite * 100).round().astype(int).ravel().tolist()
    return rounded


def _trail(robot: RobotState) -> list[list[float]]:
    step = max(len(robot.trail) // MOST_TRAIL_POINTS, 1)
    return _places(list(robot.trail)[::step])


ROBOT_PARTS: Mapping[str, Callable[[RobotState], Any]] = {
    "pose": _pose,
    "frame": lambda robot: escape_control(robot.frame),
    "zones": lambda robot: [
        shown([zone.name, zone.x, zone.y, zone.radius, zone.colour]) for zone in robot.zones
    ],
    "scan": _scan,
    "trail": _trail,
    "others": lambda robot: [
        [escape_control(name), *shown([pose.x, pose.y, pose.yaw])]
        for name, pose in robot.others.items()
    ],
}
"""The parts of a robot that are shown besides its map, by name; m and rad, except the scan."""


def _places(points: Sequence[tuple[float, float]]) -> list[list[float]]:
    """Return places to the centimetre, without invalid ones."""
    places = np.asarray(points, np.float64).reshape(-1, 2)
    rounded: list[list[float]] = places[np.isfinite(places).all(axis=1)].round(2).tolist()
    return rounded


def grid(known: Map | None) -> dict[str, Any] | None:
    """Return a map, its cells row by row in runs: a kind (0 free, 1 unknown, 2 wall) and a length.

    None if it is not known, or its size and its cells disagree.
    """
    if known is None:
        return None
    cells = np.frombuffer(known.cells, np.int8)
    if not len(cells) or len(cells) != known.width * known.height:
        return None
    kinds = np.where(cells < 0, 1, np.where(cells >= OCCUPIED, 2, 0))
    starts = [0, *(np.flatnonzero(np.diff(kinds)) + 1).tolist(), len(kinds)]
    runs = [[int(kinds[first]), after - first] for first, after in pairwise(starts)]
    facts: dict[str, Any] = shown(
        {
            "width": known.width,
            "height": known.height,
            "resolution": known.resolution,
            "origin": [known.x, known.y, known.yaw],
            "runs": runs,
        }
    )
    return facts
