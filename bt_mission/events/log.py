"""What happens in a mission as lines: of a log, of a trace, on ``/rosout``, as JSON."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass
from typing import Any

from py_trees.common import Status

from bt_mission.core.stamps import NS
from bt_mission.core.text import can_encode, escape_control
from bt_mission.events.events import (
    GoalChanged,
    LogLine,
    MissionEvent,
    MissionStarted,
    MissionStateChanged,
    NodeProgressed,
    NodeStatusChanged,
    RequirementChanged,
    VariableChanged,
)
from bt_mission.goals.goal import GoalStatus

UNICODE = {Status.SUCCESS: "✓", Status.FAILURE: "✗", Status.RUNNING: "▶", Status.INVALID: "·"}
ASCII = {Status.SUCCESS: "+", Status.FAILURE: "x", Status.RUNNING: ">", Status.INVALID: "-"}
STYLES = {
    Status.SUCCESS: "green",
    Status.FAILURE: "red",
    Status.RUNNING: "bold cyan",
    Status.INVALID: "dim",
}


def glyphs_for(encoding: str | None) -> dict[Status, str]:
    """The glyphs that a stream of this encoding can show."""
    return UNICODE if can_encode("".join(UNICODE.values()), encoding) else ASCII


LOG_ENTRIES = 1_000
"""Lines that a view keeps."""

LOG_KIND = "Log"
"""The class of nodes that speak; what they say is in the log as it is said."""


@dataclass(frozen=True)
class LogEntry:
    """A line of the log: a leaf that starts or ends, or something that is said.

    Args:
        status: That of the leaf; None for what is said.
        name: Of the leaf, or what the mission's state is.
    """

    time_ns: int
    status: Status | None
    name: str
    text: str


def entry_of(happening: MissionEvent) -> LogEntry | None:
    """Return the line for a happening; None for those that a log need not have.

    Composites follow from their leaves, and what was the case before the watcher came is in the
    tree.
    """
    match happening:
        case MissionStarted(time_ns, mission=mission):
            return LogEntry(time_ns, None, mission, "begins")
        case NodeStatusChanged(int() as time_ns, _, node, status, message, True) if (
            node.kind != LOG_KIND
        ):
            if status is Status.INVALID and not message:
                return None  # made ready to run once more
            return LogEntry(time_ns, status, node.name, "" if status is Status.RUNNING else message)
        case LogLine(time_ns, text=text):
            return LogEntry(time_ns, None, "", text)
        case MissionStateChanged(time_ns, str(run), _, state, reason) if run:
            return LogEntry(time_ns, None, *mission_state(state, reason))
    return None


def mission_state(state: str, reason: str) -> tuple[str, str]:
    """Return a line of the log for a mission's state, and why, each word once."""
    return (f"mission {reason}", "") if reason.startswith(state) else (f"mission {state}", reason)


def verdict(status: str, reason: str) -> str:
    """Return a mission's state and why, without saying the same word twice."""
    return reason if reason.startswith(status) else ": ".join(filter(None, (status, reason)))


# ---- lines of a trace ---------------------------------------------------------------------------


DEBUG, INFO, WARN, ERROR = 10, 20, 30, 40
"""Levels of ``rcl_interfaces/msg/Log``."""

ENDS = {"SUCCESS": INFO, "FAILURE": WARN}


def line_of(event: dict[str, Any], glyphs: dict[Status, str] = UNICODE) -> str:
    """Return an event of a trace in one line for people, escaped, without its time.

    An event of a kind that is not known here is told by its fields.
    """
    try:
        line = _told(event, glyphs)
    except (KeyError, TypeError, ValueError):
        line = None  # of another author: still told, if without grace
    if line is None:
        fields = ", ".join(
            f"{key} {one}" for key, one in event.items() if key not in ("t", "event")
        )
        line = f"  {event['event']}: {fields}" if fields else f"  {event['event']}"
    return escape_control(line)


def _told(event: dict[str, Any], glyphs: dict[Status, str]) -> str | None:
    line: str | None = None
    kind, _, what = event["event"].partition(" ")
    match kind:
        case "start":
            where = f"in {event['world']}, robot {event['robot']}, seed {event['seed']}"
            line = f"mission {event['mission']} {where}"
        case "status":
            status = Status[event["status"]]
            said = "" if status is Status.RUNNING else f"  {event['message']}"
            line = f"{glyphs[status]} {event['node']}{said}".rstrip()
        case "goal":
            about = f"at {event['action']} {what}{_end(event)} ({event['owner']})"
            line = f"  goal {event['goal'][:8]} {about}"
        case "pose":
            x, y, yaw = float(event["x"]), float(event["y"]), math.degrees(float(event["yaw"]))
            hits = event["collisions"]
            line = f"  robot at ({x:.3f}, {y:.3f}) m, {yaw:.1f} deg, {hits} collisions"
        case "mission":
            line = f"mission ended: {verdict(event['status'], event['reason'])}"
        case "log":
            line = f"  {event['text']}"
        case "fault":
            given = ", ".join(f"{name}={one!r}" for name, one in event.get("with", {}).items())
            about = f"{event['state']}: {event['what']}({given})".removesuffix("()")
            line = f"  fault {event['number']} {about}"
        case "clock":
            line = f"  the {_jump(event)}"
        case "requirement":
            line = f"  requirement {event['name']}: {event['verdict']}{_margin(event)}"
    return line


def rosout_line(line: str) -> tuple[int, str] | None:
    """Return the level and text on ``/rosout`` of a line of a trace; None where it has none."""
    if '"event": "pose"' in line:
        return None  # the most frequent, and nothing for people
    event: dict[str, Any] = json.loads(line)
    kind, _, what = str(event.get("event")).partition(" ")
    said: tuple[int, str] | None = None
    match kind:
        case "log":
            said = INFO, str(event["text"])
        case "status" if event["status"] in ENDS and event["message"]:
            said = ENDS[event["status"]], f"'{event['node']}' {event['message']}"
        case "mission":
            level = INFO if event["status"] == "success" else ERROR
            said = level, f"mission: {verdict(event['status'], event['reason'])}"
        case "resumed":
            said = INFO, "resumed"
        case "paused":
            said = WARN, f"paused{_reason(event)}"
        case "clock":
            said = WARN, f"the ROS {_jump(event)}"
        case "requirement":
            said = ERROR, f"requirement {event['name']}: {event['verdict']}{_margin(event)}"
        case "goal":
            about = f"of '{event['owner']}' to {event['action']} {what}{_end(event)}"
            said = WARN if what == "abandoned" else DEBUG, f"goal {event['goal'][:8]} {about}"
    return said


def _margin(event: dict[str, Any]) -> str:
    margin = event["margin"]
    return "" if margin is None else f" by {abs(margin):.4g} {event['unit']}".rstrip()


def _reason(event: dict[str, Any]) -> str:
    return f": {event['reason']}" if event["reason"] else ""


def _end(event: dict[str, Any]) -> str:
    return "" if event["status"] is None else f": {GoalStatus(event['status']).name.lower()}"


def _jump(event: dict[str, Any]) -> str:
    jump_s = float(event["jump"])
    return f"clock {'was set back by' if jump_s < 0 else 'skipped'} {abs(jump_s):g} s"


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
        case RequirementChanged(time_ns):
            names = ("name", "requirement", "verdict", "margin", "unit", "at", "violated_at")
            return "requirement", time_ns, _some(fields, *names, "on_violation", "sources", "why")


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
