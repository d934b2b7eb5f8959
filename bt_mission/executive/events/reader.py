"""ROS messages as plain data.

The reader uses only attributes, so any object with the fields is accepted.

It reads messages of rclpy and messages decoded from a recording.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

from py_trees.common import Status

from bt_mission.base.geometry import yaw_of
from bt_mission.base.stamps import to_ns as time_ns
from bt_mission.executive.events import events
from bt_mission.executive.events.codec import event_of
from bt_mission.executive.events.messages import (
    Batch,
    BatteryState,
    CameraImage,
    FrameTransform,
    Map,
    ScanPoints,
    ZoneDisc,
    Zones,
)
from bt_mission.executive.events.mission_file import MissionOrigin
from bt_mission.executive.goals.poses import NamedPose

STATUSES = (Status.INVALID, Status.RUNNING, Status.SUCCESS, Status.FAILURE)
"""In the order of the values of ``bt_mission_interfaces/msg/NodeStatus``."""

CYLINDER, TEXT_VIEW_FACING = 3, 9
"""Kinds of ``visualization_msgs/msg/Marker``."""

MOST_ZONES = 200


def tree(message: Any) -> Batch:
    """Return a ``Tree``; after a revision, as such.

    A parent that does not precede its child is taken for the root.
    """
    nodes = tuple(
        events.NodeInfo(
            node.name,
            node.kind,
            node.path,
            node.parent if node.parent < index else 0,
            tuple(node.details),
        )
        for index, node in enumerate(message.nodes)
    )
    start_ns = time_ns(message.stamp)
    revision, file = int(message.revision), MissionOrigin(message.file, message.sha256)
    if not revision:
        started = events.RunStarted(start_ns, message.run, message.mission, nodes)
        return Batch(message.run, (started,), file=file)
    revised = events.TreeRevised(
        time_ns(message.revised),
        message.run,
        message.mission,
        nodes,
        tuple(map(int, message.kept)),
        revision,
        message.summary,
        start_ns,
    )
    return Batch(message.run, (revised,), revision=revision, file=file)


def requirements(message: Any) -> Batch:
    """Return ``Requirements``."""
    stamp_ns = time_ns(message.stamp)
    return Batch(
        message.run,
        tuple(
            events.RequirementChanged(
                stamp_ns,
                requirement.name,
                requirement.requirement,
                requirement.verdict,
                _number(requirement.margin),
                requirement.unit,
                _number(requirement.at),
                _number(requirement.violated_at),
                requirement.on_violation,
                tuple(requirement.sources),
                requirement.why,
                requirement.outcome,
            )
            for requirement in message.requirements
        ),
    )


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def changes(message: Any) -> Batch:
    """Return ``StatusChanges``."""
    stamp_ns = time_ns(message.stamp)
    changed: list[events.Event] = list(_statuses(message.changes, stamp_ns))
    if len(message.reset):
        changed.append(events.NodesReset(stamp_ns, tuple(map(int, message.reset))))
    return Batch(message.run, tuple(changed), message.sequence, revision=int(message.revision))


def statuses(answer: Any) -> Batch:
    """Return the response of ``GetStatuses``."""
    known = tuple(_statuses(answer.statuses, None))
    return Batch(answer.run, known, answer.sequence, True, answer.revision)


def _statuses(messages: Any, stamp_ns: int | None) -> Iterator[events.NodeChanged]:
    for message in messages:
        yield events.NodeChanged(stamp_ns, message.node, _status(message.status), message.message)


def _status(code: int) -> Status:
    """Return a status; an unknown code, of a newer executive, counts as INVALID."""
    return STATUSES[code] if 0 <= code < len(STATUSES) else Status.INVALID


def state(message: Any) -> Batch:
    """Return a ``MissionState``."""
    changed = events.StateChanged(
        time_ns(message.stamp), message.run, message.mission, message.status, message.reason
    )
    return Batch(message.run, (changed,))


def details(message: Any) -> Batch:
    """Return ``MissionDetails``."""
    stamp_ns = time_ns(message.stamp)
    known: list[events.Event] = [
        events.CountsChanged(stamp_ns, message.ticks, message.goals_sent),
        events.BreakpointsChanged(stamp_ns, tuple(message.breakpoints)),
    ]
    known += (
        events.NodeProgressed(
            stamp_ns,
            running.node,
            time_ns(running.since),
            running.message,
            running.label,
            running.value,
            running.limit,
        )
        for running in message.running
    )
    known += map(_goal, message.goals)
    known += (
        events.VariableChanged(stamp_ns, variable.name, variable.value)
        for variable in message.variables
    )
    return Batch(message.run, tuple(known))


def _goal(goal: Any) -> events.GoalChanged:
    return events.GoalChanged(
        time_ns(goal.changed),
        goal.goal_id,
        goal.action,
        goal.owner,
        time_ns(goal.sent),
        goal.state,
        targets=tuple(NamedPose(point.x, point.y, 0.0, "map") for point in goal.targets),
    )


def log(message: Any) -> Batch:
    """Return a ``MissionLog``; an unknown event is the line that describes it."""
    stamp_ns = time_ns(message.stamp)
    event: events.Event | None = None
    if message.event:
        with suppress(LookupError, TypeError, ValueError, RecursionError):
            event = event_of({**json.loads(message.event), "t": stamp_ns}, {})
    if event is None or event.event_topic != "log":
        event = events.LogLine(stamp_ns, message.text)
    return Batch(message.run, (event,))


def transforms(message: Any) -> tuple[FrameTransform, ...]:
    """Return a ``tf2_msgs/TFMessage``, projected on the floor."""
    return tuple(
        FrameTransform(
            transform.header.frame_id.lstrip("/"),
            transform.child_frame_id.lstrip("/"),
            transform.transform.translation.x,
            transform.transform.translation.y,
            yaw_of(transform.transform.rotation),
        )
        for transform in message.transforms
    )


def scan(message: Any) -> ScanPoints:
    """Return a ``LaserScan``."""
    return ScanPoints(
        message.header.frame_id.lstrip("/"),
        message.angle_min,
        message.angle_increment,
        message.range_min,
        message.range_max,
        tuple(message.ranges),
    )


def grid(message: Any) -> Map:
    """Return an ``OccupancyGrid``."""
    info = message.info
    at = info.origin
    return Map(
        info.resolution,
        info.width,
        info.height,
        at.position.x,
        at.position.y,
        yaw_of(at.orientation),
        memoryview(message.data).tobytes(),
    )


def zones(message: Any) -> Zones:
    """Return the discs of a ``MarkerArray``, each with the text that has its number."""
    names = {
        marker.id: marker.text for marker in message.markers if marker.type == TEXT_VIEW_FACING
    }
    discs = [
        ZoneDisc(
            names.get(marker.id, ""),
            marker.pose.position.x,
            marker.pose.position.y,
            marker.scale.x / 2,
            _hex_colour(marker.color),
        )
        for marker in message.markers
        if marker.type == CYLINDER
    ]
    sound = [
        disc for disc in discs if math.isfinite(disc.x + disc.y + disc.radius) and disc.radius > 0
    ]
    return Zones(tuple(sound[:MOST_ZONES]))


def _hex_colour(colour: Any) -> str:
    parts = [part if 0 <= part <= 1 else 0.0 for part in (colour.r, colour.g, colour.b)]
    return "#" + "".join(f"{round(255 * part):02x}" for part in parts)


def battery(message: Any) -> BatteryState:
    """Return a ``BatteryState``."""
    return BatteryState(message.percentage, message.voltage)


def image(message: Any) -> CameraImage:
    """Return an ``Image``."""
    return CameraImage(
        message.width,
        message.height,
        message.step,
        message.encoding,
        memoryview(message.data).tobytes(),
    )
