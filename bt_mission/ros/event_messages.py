"""Events as ROS messages; :mod:`bt_mission.executive.events.reader` reads them."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Any

from bt_mission_interfaces.msg import (
    GoalRecord,
    MissionLog,
    MissionState,
    NodeProgress,
    NodeStatus,
    Requirement,
    Requirements,
    StatusChanges,
    Tree,
    TreeNode,
)
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point
from py_trees.common import Status

from bt_mission.base.stamps import set_ns
from bt_mission.executive.events.codec import fields_of
from bt_mission.executive.events.events import (
    Event,
    GoalChanged,
    LogLine,
    NodeChanged,
    NodeInfo,
    NodeProgressed,
    NodesReset,
    RequirementChanged,
    RunStarted,
    StateChanged,
    TreeRevised,
)
from bt_mission.executive.events.log import words_of
from bt_mission.executive.events.mission_file import MissionOrigin
from bt_mission.language.mission import Mission

CODES = {
    Status.INVALID: NodeStatus.INVALID,
    Status.RUNNING: NodeStatus.RUNNING,
    Status.SUCCESS: NodeStatus.SUCCESS,
    Status.FAILURE: NodeStatus.FAILURE,
}


def stamp(time_ns: int) -> Time:
    """Return a time in ns as a stamp."""
    message: Time = set_ns(Time(), time_ns)
    return message


def tree(event: RunStarted, mission: Mission, revised: TreeRevised | None = None) -> Tree:
    """Return the tree of a run that has started, with its newest revision and its file."""
    newest = {} if revised is None else _revision(revised)
    file = MissionOrigin.of(mission)
    return Tree(
        **newest,
        stamp=stamp(event.time_ns),
        run=event.run,
        mission=event.mission,
        nodes=list(map(_tree_node, event.nodes)),
        file=file.path,
        sha256=file.sha256,
    )


@lru_cache(maxsize=4096)
def _tree_node(node: NodeInfo) -> TreeNode:
    """Return a node of a tree. Most nodes of a revision are those of the tree before."""
    return TreeNode(
        name=node.name,
        kind=node.kind,
        path=node.path,
        parent=node.parent,
        details=node.details,
    )


def _revision(event: TreeRevised) -> dict[str, Any]:
    return {
        "revision": event.number,
        "revised": stamp(event.time_ns),
        "kept": list(event.kept),
        "summary": event.summary,
    }


def node_status(index: int, status: Status, message: str) -> NodeStatus:
    """Return the status of a node."""
    return NodeStatus(node=index, status=CODES[status], message=message)


def changes(
    time_ns: int,
    run: str,
    sequence: int,
    events: Iterable[NodeChanged | NodesReset],
    revision: int = 0,
) -> StatusChanges:
    """Return the changes of nodes in one tick."""
    message = StatusChanges(stamp=stamp(time_ns), run=run, sequence=sequence, revision=revision)
    for event in events:
        if isinstance(event, NodesReset):
            message.reset.extend(event.nodes)
        else:
            message.changes.append(node_status(event.node, event.status, event.message))
    return message


def state(event: StateChanged) -> MissionState:
    """Return the state of a mission."""
    return MissionState(
        stamp=stamp(event.time_ns),
        run=event.run,
        mission=event.mission,
        status=event.status,
        reason=event.explanation,
    )


def requirements(time_ns: int, run: str, events: Iterable[RequirementChanged]) -> Requirements:
    """Return the verdicts of requirements."""
    return Requirements(
        stamp=stamp(time_ns),
        run=run,
        requirements=[
            Requirement(
                name=event.name,
                requirement=event.requirement,
                verdict=event.verdict,
                outcome=event.outcome,
                margin=_number(event.margin),
                unit=event.unit,
                at=_number(event.at),
                violated_at=_number(event.violated_at),
                on_violation=event.on_violation,
                sources=event.sources,
                why=event.why,
            )
            for event in events
        ],
    )


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def progress(event: NodeProgressed) -> NodeProgress:
    """Return the progress of a node."""
    return NodeProgress(
        node=event.node,
        since=stamp(event.since_ns),
        message=event.message,
        label=event.label,
        value=event.value,
        limit=event.limit,
    )


def goal(event: GoalChanged, changed_ns: int) -> GoalRecord:
    """Return the state of a goal, and since when it has that."""
    return GoalRecord(
        goal_id=event.id,
        action=event.action,
        owner=event.owner,
        sent=stamp(event.sent_ns),
        changed=stamp(changed_ns),
        state=event.state,
        targets=[Point(x=target.x, y=target.y) for target in event.targets],
    )


def log(event: Event, run: str, nodes: Sequence[NodeInfo]) -> MissionLog:
    """Return a line of a mission, or an event without another topic, also as text."""
    message = MissionLog(stamp=stamp(event.time_ns or 0), run=run)
    if isinstance(event, LogLine):
        message.text = event.text
    else:
        fields = fields_of(event, nodes)
        message.text, message.event = words_of(fields), json.dumps(fields, sort_keys=True)
    return message
