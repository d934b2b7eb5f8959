"""ROS messages as plain data. Looks only at attributes, so whatever has the fields will do.

Messages that were decoded from a recording do as well as rclpy's own.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

from py_trees.common import Status

from bt_mission.core.geometry import yaw_of
from bt_mission.core.stamps import to_ns as time_ns
from bt_mission.events import events
from bt_mission.events import messages as told
from bt_mission.events.codec import event_of
from bt_mission.events.messages import Batch
from bt_mission.goals.poses import NamedPose

STATUSES = (Status.INVALID, Status.RUNNING, Status.SUCCESS, Status.FAILURE)
"""In the order of the values of ``bt_mission_interfaces/msg/NodeStatus``."""

CYLINDER, TEXT_VIEW_FACING = 3, 9
"""Kinds of ``visualization_msgs/msg/Marker``."""

MOST_ZONES = 200


def tree(message: Any) -> Batch:
    """Return a ``Tree``; a parent that does not come before its child is taken for the root."""
    nodes = tuple(
        events.NodeInfo(
            one.name,
            one.kind,
            one.path,
            one.parent if one.parent < index else 0,
            tuple(one.details),
        )
        for index, one in enumerate(message.nodes)
    )
    started = events.RunStarted(time_ns(message.stamp), message.run, message.mission, nodes)
    return Batch(message.run, (started,))


def requirements(message: Any) -> Batch:
    """Return ``Requirements``."""
    stamp_ns = time_ns(message.stamp)
    return Batch(
        message.run,
        tuple(
            events.RequirementChanged(
                stamp_ns,
                one.name,
                one.requirement,
                one.verdict,
                _number(one.margin),
                one.unit,
                _number(one.at),
                _number(one.violated_at),
                one.on_violation,
                tuple(one.sources),
                one.why,
                one.outcome,
            )
            for one in message.requirements
        ),
    )


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def changes(message: Any) -> Batch:
    """Return ``StatusChanges``."""
    stamp_ns = time_ns(message.stamp)
    found: list[events.Event] = list(_statuses(message.changes, stamp_ns))
    if len(message.reset):
        found.append(events.NodesReset(stamp_ns, tuple(map(int, message.reset))))
    return Batch(message.run, tuple(found), message.sequence)


def statuses(answer: Any) -> Batch:
    """Return the answer of ``GetStatuses``."""
    return Batch(answer.run, tuple(_statuses(answer.statuses, None)), answer.sequence, True)


def _statuses(messages: Any, stamp_ns: int | None) -> Iterator[events.NodeChanged]:
    for one in messages:
        yield events.NodeChanged(stamp_ns, one.node, _status(one.status), one.message)


def _status(code: int) -> Status:
    """Return a status; a code that a newer executive may have counts as INVALID."""
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
    found: list[events.Event] = [
        events.CountsChanged(stamp_ns, message.ticks, message.goals_sent),
        events.BreakpointsChanged(stamp_ns, tuple(message.breakpoints)),
    ]
    found += (
        events.NodeProgressed(
            stamp_ns, one.node, time_ns(one.since), one.message, one.label, one.value, one.limit
        )
        for one in message.running
    )
    found += map(_goal, message.goals)
    found += (events.VariableChanged(stamp_ns, one.name, one.value) for one in message.variables)
    return Batch(message.run, tuple(found))


def _goal(one: Any) -> events.GoalChanged:
    return events.GoalChanged(
        time_ns(one.changed),
        one.goal_id,
        one.action,
        one.owner,
        time_ns(one.sent),
        one.state,
        targets=tuple(NamedPose(point.x, point.y, 0.0, "map") for point in one.targets),
    )


def log(message: Any) -> Batch:
    """Return a ``MissionLog``; an event that is not known here is the line that describes it."""
    stamp_ns = time_ns(message.stamp)
    event: events.Event | None = None
    if message.event:
        with suppress(LookupError, TypeError, ValueError, RecursionError):
            event = event_of({**json.loads(message.event), "t": stamp_ns}, {})
    if event is None or event.event_topic != "log":
        event = events.LogLine(stamp_ns, message.text)
    return Batch(message.run, (event,))


def transforms(message: Any) -> tuple[told.FrameTransform, ...]:
    """Return a ``tf2_msgs/TFMessage``, seen from above."""
    return tuple(
        told.FrameTransform(
            one.header.frame_id.lstrip("/"),
            one.child_frame_id.lstrip("/"),
            one.transform.translation.x,
            one.transform.translation.y,
            yaw_of(one.transform.rotation),
        )
        for one in message.transforms
    )


def scan(message: Any) -> told.ScanPoints:
    """Return a ``LaserScan``."""
    return told.ScanPoints(
        message.header.frame_id.lstrip("/"),
        message.angle_min,
        message.angle_increment,
        message.range_min,
        message.range_max,
        tuple(message.ranges),
    )


def grid(message: Any) -> told.Map:
    """Return an ``OccupancyGrid``."""
    info = message.info
    at = info.origin
    return told.Map(
        info.resolution,
        info.width,
        info.height,
        at.position.x,
        at.position.y,
        yaw_of(at.orientation),
        memoryview(message.data).tobytes(),
    )


def zones(message: Any) -> told.Zones:
    """Return the discs of a ``MarkerArray``, each with the text that has its number."""
    names = {one.id: one.text for one in message.markers if one.type == TEXT_VIEW_FACING}
    discs = [
        told.ZoneDisc(
            names.get(one.id, ""),
            one.pose.position.x,
            one.pose.position.y,
            one.scale.x / 2,
            _hex_colour(one.color),
        )
        for one in message.markers
        if one.type == CYLINDER
    ]
    sound = [one for one in discs if math.isfinite(one.x + one.y + one.radius) and one.radius > 0]
    return told.Zones(tuple(sound[:MOST_ZONES]))


def _hex_colour(colour: Any) -> str:
    parts = [part if 0 <= part <= 1 else 0.0 for part in (colour.r, colour.g, colour.b)]
    return "#" + "".join(f"{round(255 * part):02x}" for part in parts)


def battery(message: Any) -> told.BatteryState:
    """Return a ``BatteryState``."""
    return told.BatteryState(message.percentage, message.voltage)


def image(message: Any) -> told.CameraImage:
    """Return an ``Image``."""
    return told.CameraImage(
        message.width,
        message.height,
        message.step,
        message.encoding,
        memoryview(message.data).tobytes(),
    )
