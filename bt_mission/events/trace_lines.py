"""The events of a trace as people would tell them."""

from __future__ import annotations

import math
from typing import Any

from py_trees.common import Status

from bt_mission.events.status_marks import UNICODE
from bt_mission.goals.goal import GoalStatus

KNOWN = frozenset({"t", "event"})


def line_of(event: dict[str, Any], glyphs: dict[Status, str] = UNICODE) -> str:
    """An event in one line, without its time.

    An event of a kind that is not known here is told by its fields.
    """
    tell = _TELLERS.get(event["event"].partition(" ")[0])
    try:
        return tell(event, glyphs) if tell else _fields(event)
    except (KeyError, TypeError, ValueError):
        return _fields(event)  # of another author: still told, if without grace


def _start(event: dict[str, Any], _: dict[Status, str]) -> str:
    where = f"in {event['world']}, robot {event['robot']}, seed {event['seed']}"
    return f"mission {event['mission']} {where}"


def _status(event: dict[str, Any], glyphs: dict[Status, str]) -> str:
    status = Status[event["status"]]
    said = "" if status is Status.RUNNING else f"  {event['message']}"
    return f"{glyphs[status]} {event['node']}{said}".rstrip()


def _goal(event: dict[str, Any], _: dict[Status, str]) -> str:
    what = event["event"].partition(" ")[2]
    status = event["status"]
    end = "" if status is None else f": {GoalStatus(status).name.lower()}"
    return f"  goal {event['goal'][:8]} at {event['action']} {what}{end} ({event['owner']})"


def _pose(event: dict[str, Any], _: dict[Status, str]) -> str:
    x, y, yaw = float(event["x"]), float(event["y"]), math.degrees(float(event["yaw"]))
    return f"  robot at ({x:.3f}, {y:.3f}) m, {yaw:.1f} deg, {event['collisions']} collisions"


def _mission(event: dict[str, Any], _: dict[Status, str]) -> str:
    reason = f": {event['reason']}" if event["reason"] else ""
    return f"mission ended: {event['status']}{reason}"


def _log(event: dict[str, Any], _: dict[Status, str]) -> str:
    return f"  {event['text']}"


def _fault(event: dict[str, Any], _: dict[Status, str]) -> str:
    given = ", ".join(f"{name}={value!r}" for name, value in event.get("with", {}).items())
    return f"  fault {event['number']} {event['state']}: {event['what']}({given})".removesuffix(
        "()"
    )


def _clock(event: dict[str, Any], _: dict[Status, str]) -> str:
    jump_s = float(event["jump"])
    return f"  the clock {'was set back by' if jump_s < 0 else 'skipped'} {abs(jump_s):g} s"


def _fields(event: dict[str, Any], *_: Any) -> str:
    fields = ", ".join(f"{key} {value}" for key, value in event.items() if key not in KNOWN)
    return f"  {event['event']}: {fields}" if fields else f"  {event['event']}"


_TELLERS = {
    "start": _start,
    "status": _status,
    "goal": _goal,
    "pose": _pose,
    "mission": _mission,
    "log": _log,
    "fault": _fault,
    "clock": _clock,
}
