"""ROS messages as plain data. Looks only at attributes, so whatever has the fields will do.

Messages that were decoded from a recording do as well as rclpy's own.
"""

from __future__ import annotations

import json
import math
from typing import Any

from py_trees.common import Status

from bt_mission.core.geometry import yaw_of
from bt_mission.core.stamps import to_ns as time_ns
from bt_mission.events import events
from bt_mission.events import messages as told

STATUSES = (Status.INVALID, Status.RUNNING, Status.SUCCESS, Status.FAILURE)
"""In the order of the values of ``bt_mission_interfaces/msg/NodeStatus``."""

CYLINDER, TEXT_VIEW_FACING = 3, 9
"""Kinds of ``visualization_msgs/msg/Marker``."""

MOST_ZONES = 200


def tree(message: Any) -> events.MissionStarted:
    """Return a ``Tree``; a parent that does not come before its child is taken for the root."""
    nodes = tuple(
        events.NodeInfo(one.name, one.kind, one.path, one.parent if one.parent < index else 0)
        for index, one in enumerate(message.nodes)
    )
    return events.MissionStarted(time_ns(message.stamp), message.run, message.mission, nodes)


def node_details(message: Any) -> told.NodeDetails:
    """Return the JSON of ``~/node_details``; empty where it is none of ours."""
    try:
        found = json.loads(message.data)
        nodes = {path: tuple(map(str, lines)) for path, lines in found["nodes"].items()}
        return told.NodeDetails(str(found["run"]), nodes)
    except (ValueError, TypeError, KeyError, AttributeError):
        return told.NodeDetails("", {})


def requirements(message: Any) -> told.Requirements:
    """Return the ``DiagnosticArray`` of ``~/requirements``; empty where it is none of ours."""
    stamp_ns = time_ns(message.header.stamp)
    found = tuple(_requirement(one, stamp_ns) for one in message.status)
    return told.Requirements(stamp_ns, found[0].run if found else "", found)


def _requirement(status: Any, stamp_ns: int) -> events.RequirementChanged:
    text = {one.key: one.value for one in status.values}.get
    return events.RequirementChanged(
        time_ns=stamp_ns,
        run=text("run", ""),
        name=status.name,
        requirement=text("requirement", ""),
        verdict=text("verdict", ""),
        margin=_number(text("margin", "")),
        unit=text("unit", ""),
        at=_number(text("at", "")),
        violated_at=_number(text("violated_at", "")),
        on_violation=text("on_violation", ""),
        sources=tuple(filter(None, text("sources", "").split("; "))),
        why=text("why", ""),
        outcome=status.message,
    )


def _number(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if math.isfinite(number) else None


def changes(message: Any) -> told.Changes:
    """Return ``StatusChanges``."""
    return told.Changes(
        time_ns(message.stamp), message.run, message.sequence, _standings(message.changes)
    )


def statuses(answer: Any) -> told.Statuses:
    """Return the answer of ``GetStatuses``."""
    return told.Statuses(answer.run, answer.sequence, _standings(answer.statuses))


def state(message: Any) -> events.MissionStateChanged:
    """Return a ``MissionState``."""
    return events.MissionStateChanged(
        time_ns(message.stamp), message.run, message.mission, message.status, message.reason
    )


def details(message: Any) -> told.DetailsUpdate:
    """Return ``MissionDetails``."""
    return told.DetailsUpdate(
        time_ns(message.stamp),
        message.run,
        message.ticks,
        message.goals_sent,
        tuple(
            events.NodeProgress(
                one.node, time_ns(one.since), one.message, one.label, one.value, one.limit
            )
            for one in message.running
        ),
        tuple(_goal(one) for one in message.goals),
        tuple((one.name, one.value) for one in message.variables),
        tuple(message.breakpoints),
    )


def said(message: Any) -> events.LogLine:
    """Return a ``MissionLog``."""
    return events.LogLine(time_ns(message.stamp), message.run, message.text)


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


def _standings(messages: Any) -> tuple[told.NodeStatus, ...]:
    return tuple(told.NodeStatus(one.node, _status(one.status), one.message) for one in messages)


def _status(code: int) -> Status:
    """Return a status; a code that a newer executive may have counts as none."""
    return STATUSES[code] if 0 <= code < len(STATUSES) else Status.INVALID


def _goal(one: Any) -> events.GoalChanged:
    return events.GoalChanged(
        one.goal_id,
        one.action,
        one.owner,
        time_ns(one.sent),
        time_ns(one.changed),
        one.state,
        tuple((point.x, point.y) for point in one.targets),
    )
