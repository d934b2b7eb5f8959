"""What happens in a mission as JSON objects, for programs: one a line."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from typing import Any

from bt_mission.core.stamps import NS
from bt_mission.events.events import (
    GoalChanged,
    LogLine,
    MissionEvent,
    MissionStarted,
    MissionStateChanged,
    NodeProgressed,
    NodeStatusChanged,
    VariableChanged,
)


def as_object(happening: MissionEvent) -> dict[str, Any]:
    """Return a happening as an object: ``event`` says what it is, ``t`` is ROS time in seconds.

    ``t`` is null where only the present is known, since the watcher came later.
    """
    match happening:
        case MissionStarted(time_ns):
            return _event("tree", time_ns, **_fields(happening, "run", "mission", "nodes"))
        case NodeStatusChanged(time_ns, index, node, status, message):
            return _event(
                "status",
                time_ns,
                index=index,
                node=node.name,
                path=node.path,
                status=status.value.lower(),
                message=message,
            )
        case NodeProgressed(time_ns, node, progress):
            measured = (
                {"label": progress.label, "value": progress.value, "limit": progress.limit}
                if progress.limit and math.isfinite(progress.value + progress.limit)
                else {}
            )
            return _event(
                "progress",
                time_ns,
                node=node.name,
                path=node.path,
                since=progress.since_ns / NS,
                message=progress.message,
                **measured,
            )
        case MissionStateChanged(time_ns):
            fields = _fields(happening, "run", "mission", "status", "reason")
            return _event("mission", time_ns, **fields)
        case GoalChanged(goal):
            fields = _fields(happening, "action", "owner", "state")
            sent_s = happening.sent_ns / NS
            return _event("goal", happening.changed_ns, goal=goal, **fields, sent=sent_s)
        case VariableChanged(time_ns, name, value):
            return _event("variable", time_ns, name=name, value=_read(value))
        case LogLine(time_ns, text=text):
            return _event("log", time_ns, text=text)


def as_line(event: dict[str, Any]) -> str:
    """Return an object as one line of JSON."""
    return json.dumps(event, allow_nan=False)


def _fields(happening: MissionEvent, *names: str) -> dict[str, Any]:
    fields = asdict(happening)
    return {name: fields[name] for name in names}


def _event(event: str, time_ns: int | None, **fields: Any) -> dict[str, Any]:
    return {"event": event, "t": None if time_ns is None else time_ns / NS, **fields}


def _read(value: str) -> Any:
    """Return a variable's value; one that was cut, or holds what JSON has not, as its text."""
    try:
        return json.loads(value, parse_constant=lambda _: _not_json())
    except ValueError:
        return value


def _not_json() -> Any:
    raise ValueError
