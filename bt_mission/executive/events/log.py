"""The events of a mission as lines for people: of a log, of a trace, on ``/rosout``."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from py_trees.common import Status

from bt_mission.base.text import can_encode, escape_control
from bt_mission.executive.events.codec import fields_of
from bt_mission.executive.events.events import (
    FINAL,
    ClockJumped,
    Event,
    FaultChanged,
    GoalChanged,
    LogLine,
    NodeChanged,
    NodeInfo,
    RequirementChanged,
    StateChanged,
    TreeRevised,
)
from bt_mission.executive.goals.goal import GoalStatus

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
"""The class of nodes that log; their lines are in the log unchanged."""


@dataclass(frozen=True)
class LogEntry:
    """A line of the log: a leaf that starts or ends, or a message.

    Args:
        status: The status of the leaf; None for a message.
        name: The name of the leaf, or the mission's state.
    """

    time_ns: int
    status: Status | None
    name: str
    text: str


def mission_state(state: str, reason: str) -> tuple[str, str]:
    """Return a line of the log for a mission's state and its reason, without repeated words."""
    return (f"mission {reason}", "") if reason.startswith(state) else (f"mission {state}", reason)


def verdict(status: str, reason: str) -> str:
    """Return a mission's state and its reason, without repeated words."""
    return reason if reason.startswith(status) else ": ".join(filter(None, (status, reason)))


# ---- lines of a trace ---------------------------------------------------------------------------


DEBUG, INFO, WARN, ERROR = 10, 20, 30, 40
"""Levels of ``rcl_interfaces/msg/Log``."""

ENDS = {Status.SUCCESS: INFO, Status.FAILURE: WARN}


def line_of(fields: dict[str, Any], glyphs: dict[Status, str] = UNICODE) -> str:
    """Return an event as one line for people, escaped, without its time.

    An event without words of its own is shown by its fields.

    Args:
        fields: The fields of a line of a trace, or of an event
            (:func:`bt_mission.executive.events.codec.fields_of`).
    """
    try:
        line = _words(fields, glyphs)
    except (AttributeError, KeyError, TypeError, ValueError):
        line = None  # of another author
    if line is None:
        shown = {key: value for key, value in fields.items() if key not in UNSHOWN}
        words = ", ".join(f"{key} {value}" for key, value in shown.items())
        line = f"  {fields['event']}: {words}" if words else f"  {fields['event']}"
    return escape_control(line)


def words_of(fields: dict[str, Any]) -> str:
    """Return an event of ``~/log`` as text, as :func:`line_of` does, without space for a sign."""
    return line_of(fields).strip()


def speech_of(event: Event) -> str | None:
    """Return the line that the mission logs with an event; None without one."""
    match event:
        case LogLine(text=text):
            return text
        case FaultChanged():
            return words_of(fields_of(event))
    return None


def _start_words(event: dict[str, Any]) -> str:
    where = f"in {event['world']}, robot {event['robot']}, seed {event['seed']}"
    return f"mission {event['mission']} {where}"


def _revised_words(event: dict[str, Any]) -> str:
    return f"mission revised ({event['number']}): {event['summary']}"


def _goal_words(event: dict[str, Any]) -> str:
    change, status = event["event"].removeprefix("goal "), event["status"]
    end = "" if status is None else f": {GoalStatus(status).name.lower()}"
    return f"  goal {event['goal'][:8]} at {event['action']} {change}{end} ({event['owner']})"


def _pose_words(event: dict[str, Any]) -> str:
    x, y, yaw = float(event["x"]), float(event["y"]), math.degrees(float(event["yaw"]))
    return f"  robot at ({x:.3f}, {y:.3f}) m, {yaw:.1f} deg, {event['collisions']} collisions"


def _fault_words(event: dict[str, Any]) -> str:
    given = [f"{name} {_argument(value)}" for name, value in event.get("with", {}).items()]
    return f"  fault {event['number']} {event['state']}: {' '.join([event['what'], *given])}"


def _argument(value: Any) -> str:
    """Return an argument of a fault as faults are written: sectors are (-20, 20) (160, -160)."""
    if not isinstance(value, list | tuple):
        return str(value)
    if value and isinstance(value[0], list | tuple):
        return " ".join(map(_argument, value))
    return f"({', '.join(map(str, value))})"


def _requirement_words(event: dict[str, Any]) -> str:
    margin = _margin(event["margin"], event["unit"])
    return f"  requirement {event['name']}: {event['verdict']}{margin}"


UNSHOWN = ("t", "event", "path", "index")
"""Fields that are not shown for an event that is not in `WORDS`."""

WORDS: Mapping[str, Callable[[dict[str, Any]], str]] = {
    "start": _start_words,
    "revised": _revised_words,
    "goal": _goal_words,
    "pose": _pose_words,
    "mission": lambda event: f"mission ended: {verdict(event['status'], event['reason'])}",
    "log": lambda event: f"  {event['text']}",
    "reset": lambda event: f"  reset: {', '.join(event['paths'])}",
    "fault": _fault_words,
    "clock": lambda event: f"  the {_jump(float(event['jump']))}",
    "requirement": _requirement_words,
    "untested": lambda event: f"  not tested: {event['what']}",
}
"""The words of events, except changes of status."""


def _words(event: dict[str, Any], glyphs: dict[Status, str]) -> str | None:
    kind = event["event"].partition(" ")[0]
    if kind == "status":
        status = Status[event["status"]]
        message = "" if status is Status.RUNNING else f"  {event['message']}"
        return f"{glyphs[status]} {event['node']}{message}".rstrip()
    return WORDS[kind](event) if kind in WORDS else None


def rosout_line(event: Event, nodes: Sequence[NodeInfo]) -> tuple[int, str] | None:
    """Return the level and text of an event on ``/rosout``; None without a line."""
    match event:
        case NodeChanged(_, index, status, message) if status in ENDS and message:
            return ENDS[status], f"'{nodes[index].name}' {message}"
        case LogLine(_, text, True):
            return INFO, text
        case GoalChanged(change=change) if change:
            end = f": {event.state}" if event.is_ended and event.state != "rejected" else ""
            text = f"goal {event.id[:8]} of '{event.owner}' to {event.action} {change}{end}"
            return WARN if change == "abandoned" else DEBUG, text
        case StateChanged(is_update=False):
            return _state_on_rosout(event)
        case RequirementChanged(_, name, _, "violated" as word, margin, unit) if (
            not event.is_update
        ):
            return ERROR, f"requirement {name}: {word}{_margin(margin, unit)}"
        case TreeRevised():
            return WARN, _revised_words(fields_of(event))
        case ClockJumped(_, jump_s):
            return WARN, f"the ROS {_jump(jump_s)}"
    return None


def _state_on_rosout(event: StateChanged) -> tuple[int, str] | None:
    status, reason = event.status, event.reason
    if status in FINAL:
        return INFO if status == "success" else ERROR, f"mission: {verdict(status, reason)}"
    if status == "paused":
        return WARN, "paused" + (f": {reason}" if reason else "")
    return (INFO, "resumed") if status == "running" else None


def _margin(margin: float | None, unit: str) -> str:
    return "" if margin is None else f" by {abs(margin):.4g} {unit}".rstrip()


def _jump(jump_s: float) -> str:
    return f"clock {'was set back by' if jump_s < 0 else 'skipped'} {abs(jump_s):g} s"
