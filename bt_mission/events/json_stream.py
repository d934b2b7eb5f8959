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


def json_line(happening: MissionEvent) -> str:
    """Return a happening as JSON: ``event`` says what it is, ``t`` is ROS time in seconds.

    ``t`` is null where only the present is known, since the watcher came later.
    """
    event, time_ns, fields = _parts(happening)
    t = None if time_ns is None else time_ns / NS
    return json.dumps({"event": event, "t": t, **fields}, allow_nan=False)


def _parts(happening: MissionEvent) -> tuple[str, int | None, dict[str, Any]]:
    fields = asdict(happening)
    match happening:
        case MissionStarted(time_ns):
            return "tree", time_ns, _some(fields, "run", "mission", "nodes")
        case NodeStatusChanged(time_ns, index, node, status, message):
            place = {"index": index, "node": node.name, "path": node.path}
            return "status", time_ns, {**place, "status": status.value.lower(), "message": message}
        case NodeProgressed(time_ns, node, progress):
            is_measured = progress.limit and math.isfinite(progress.value + progress.limit)
            fields = {
                "node": node.name,
                "path": node.path,
                "since": progress.since_ns / NS,
                "message": progress.message,
            }
            measured = _some(vars(progress), "label", "value", "limit") if is_measured else {}
            return "progress", time_ns, fields | measured
        case MissionStateChanged(time_ns):
            return "mission", time_ns, _some(fields, "run", "mission", "status", "reason")
        case GoalChanged(goal):
            fields = {"goal": goal, **_some(fields, "action", "owner", "state")}
            return "goal", happening.changed_ns, fields | {"sent": happening.sent_ns / NS}
        case VariableChanged(time_ns, name, value):
            return "variable", time_ns, {"name": name, "value": _read(value)}
        case LogLine(time_ns, text=text):
            return "log", time_ns, {"text": text}


def _some(fields: dict[str, Any], *names: str) -> dict[str, Any]:
    return {name: fields[name] for name in names}


def _read(value: str) -> Any:
    """Return a variable's value; one that was cut, or holds what JSON has not, as its text."""
    try:
        return json.loads(value, parse_constant=lambda _: _not_json())
    except ValueError:
        return value


def _not_json() -> Any:
    raise ValueError
