"""Events as lines of JSON, and back: of a trace, of ``~/log``, of ``watch --json``.

A line is one JSON object with sorted keys: ``t`` is ROS time, ns; ``event`` names the event; nodes
have their name and path. Floats are written so that they read back exactly. A trace has the events
and fields that follow from mission and seed alone.

An event without an entry here is written and read by its fields.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields as fields_in
from dataclasses import replace
from functools import cache
from typing import Any

from py_trees.common import Status
from pydantic import TypeAdapter

from bt_mission.executive.events.events import (
    FINAL,
    KINDS,
    BreakpointsChanged,
    Event,
    FaultChanged,
    GoalChanged,
    LogLine,
    NodeChanged,
    NodeInfo,
    NodeProgressed,
    NodesReset,
    PoseSampled,
    RequirementChanged,
    RunStarted,
    StateChanged,
    TreeRevised,
    VariableChanged,
)
from bt_mission.executive.goals.goal import GoalStatus

_ENCODER = json.JSONEncoder(sort_keys=True)  # json.dumps makes a new one for each event
_text = json.encoder.encode_basestring_ascii  # what the encoder writes a text with

GOAL_STATUS = {
    "succeeded": GoalStatus.SUCCEEDED,
    "canceled": GoalStatus.CANCELED,
    "aborted": GoalStatus.ABORTED,
    "unknown": GoalStatus.UNKNOWN,
}
"""Status of the goal's result, by the goal's final state; a rejected goal has no status."""

Nodes = Sequence[NodeInfo]


def fields_of(event: Event, nodes: Nodes = ()) -> dict[str, Any]:
    """Return the fields of an event by name, ready for JSON.

    Args:
        nodes: Of the tree that the event's indices refer to.
    """
    write: Callable[[Any, Nodes], dict[str, Any]] = FIELDS.get(type(event), _plain)
    return {"event": event.event_name, **write(event, nodes), "t": event.time_ns}


def _plain(event: Event, nodes: Nodes) -> dict[str, Any]:
    """Return the fields as they are; a node with its name and path."""
    left_out = ("time_ns", *LEFT_OUT.get(type(event), ()))
    names = (field.name for field in fields_in(event) if field.name not in left_out)
    fields = {name: getattr(event, name) for name in names}
    index = fields.get("node", -1)
    return fields | ({"index": index, **_node(index, nodes)} if 0 <= index < len(nodes) else {})


def _shown(nodes: Nodes) -> list[dict[str, Any]]:
    shown = ("name", "kind", "path", "parent")
    return [{name: getattr(node, name) for name in shown} for node in nodes]


def _started(event: RunStarted, _: Nodes) -> dict[str, Any]:
    return {
        "run": event.run,
        "mission": event.mission,
        "world": event.world,
        "robot": event.robot,
        "seed": event.seed,
        "nodes": _shown(event.nodes),
    }


def _revised(event: TreeRevised, _: Nodes) -> dict[str, Any]:
    return {
        "mission": event.mission,
        "number": event.number,
        "summary": event.summary,
        "cycle": event.cycle,
        "keep_goals": event.keep_goals,
        "kept": list(event.kept),
        "nodes": _shown(event.nodes),
    }


def _node(index: int, nodes: Nodes) -> dict[str, Any]:
    return {"node": nodes[index].name, "path": nodes[index].path}


def _changed(event: NodeChanged, nodes: Nodes) -> dict[str, Any]:
    status = {"status": event.status.value, "message": event.message}
    return {**_node(event.node, nodes), **status}


def _progressed(event: NodeProgressed, nodes: Nodes) -> dict[str, Any]:
    fields = _node(event.node, nodes) | {"since": event.since_ns, "message": event.message}
    if event.limit and math.isfinite(event.value + event.limit):
        fields |= {"label": event.label, "value": event.value, "limit": event.limit}
    return fields


def _goal(event: GoalChanged, _: Nodes) -> dict[str, Any]:
    return {
        "event": f"goal {event.change or event.state}",
        "action": event.action,
        "goal": event.id,
        "owner": event.owner,
        "phase": phase_of(event),
        "status": status_of(event),
    }


def _state(event: StateChanged, _: Nodes) -> dict[str, Any]:
    fields = {"run": event.run, "mission": event.mission, "status": event.status}
    return {**fields, "reason": event.explanation}


def _fault(event: FaultChanged, _: Nodes) -> dict[str, Any]:
    fields = {"number": event.number, "what": event.what, "state": event.state}
    return fields if event.parameters is None else {**fields, "with": event.parameters}


FIELDS: Mapping[type[Event], Callable[[Any, Nodes], dict[str, Any]]] = {
    RunStarted: _started,
    TreeRevised: _revised,
    NodeChanged: _changed,
    NodesReset: lambda event, nodes: {"paths": [nodes[index].path for index in event.nodes]},
    NodeProgressed: _progressed,
    GoalChanged: _goal,
    VariableChanged: lambda event, _: {"name": event.name, "value": _value(event.value)},
    StateChanged: _state,
    BreakpointsChanged: lambda event, _: {"nodes": event.names},
    FaultChanged: _fault,
}
"""The fields of events that are not written as they are."""

LEFT_OUT: Mapping[type[Event], tuple[str, ...]] = {
    LogLine: ("is_own",),
    RequirementChanged: ("outcome", "is_update"),
}
"""Fields of others that no line has."""


def json_line(event: Event, nodes: Nodes = ()) -> str:
    """Return an event as a line of JSON.

    ``t`` is null if the event was not observed, since the reader started later; so is a number that
    JSON lacks.
    """
    fields = fields_of(event, nodes)
    try:
        return json.dumps(fields, sort_keys=True, allow_nan=False)
    except ValueError:
        return json.dumps(_finite(fields), sort_keys=True)


def _finite(value: Any) -> Any:
    match value:
        case dict():
            return {key: _finite(item) for key, item in value.items()}
        case list() | tuple():
            return [_finite(item) for item in value]
        case float() if not math.isfinite(value):
            return None
    return value


# ---- traces -----------------------------------------------------------------------------------


def trace_line(event: Event, nodes: Nodes, names: Sequence[str]) -> str | None:
    """Return the line of an event in a trace; None for an event that a trace lacks.

    Args:
        names: The name and path of each node as :func:`node_names` writes them.
    """
    match event:
        # The three of which there are many are put together by hand, as the encoder writes them.
        case NodeChanged(time_ns, node, status, message):
            return (
                f'{{"event": "status", "message": {_text(message)}, {names[node]},'
                f' "status": {_text(status.value)}, "t": {time_ns}}}'
            )
        case GoalChanged(change=change) if change:
            return goal_line(event, f'"{event.id}"')
        case PoseSampled(time_ns, x, y, yaw, collisions) if math.isfinite(x + y + yaw):
            return (
                f'{{"collisions": {collisions}, "event": "pose", "t": {time_ns},'
                f' "x": {x!r}, "y": {y!r}, "yaw": {yaw!r}}}'
            )
        case StateChanged():
            state = _traced_state(event)
            return None if state is None else _ENCODER.encode({"t": event.time_ns, **state})
        case _ if is_traced(event):
            fields = fields_of(event, nodes)
            for name in ONLY_LIVE.get(type(event), ()):
                fields.pop(name, None)
            return _ENCODER.encode(fields)
    return None


def is_traced(event: Event) -> bool:
    """Return whether a trace has this event. Of states and goals, a trace has only some."""
    match event:
        case RunStarted(world=world):
            return world is not None
        case LogLine(is_own=is_own):
            return is_own
        case RequirementChanged(verdict=verdict, is_update=is_update):
            return verdict == "violated" and not is_update
        case GoalChanged():
            return False
    return event.is_traced


def goal_line(event: GoalChanged, goal: str) -> str:
    """Return the line of a goal in a trace, with this in the place of its id."""
    status = status_of(event)
    return (
        f'{{"action": {_text(event.action)}, "event": {_text(f"goal {event.change}")},'
        f' "goal": {goal}, "owner": {_text(event.owner)}, "phase": {_text(phase_of(event))},'
        f' "status": {"null" if status is None else status}, "t": {event.time_ns}}}'
    )


def node_names(nodes: Nodes) -> tuple[str, ...]:
    """Return name and path of each node as written in lines of a trace."""
    return tuple(f'"node": {_text(node.name)}, "path": {_text(node.path)}' for node in nodes)


def _traced_state(event: StateChanged) -> dict[str, Any] | None:
    if event.is_update:
        return None
    match event.status:
        case "paused":
            return {"event": "paused", "reason": event.reason, "keep_goals": event.keep_goals}
        case "running":
            return {"event": "resumed"}
        case "observing":
            end = {"status": event.verdict, "reason": event.reason}
            return {"event": "observing", **end, "seconds": event.observe_s}
        case status if status in FINAL:
            return {"event": "mission", "status": status, "reason": event.reason}
    return None


ONLY_LIVE: Mapping[type[Event], tuple[str, ...]] = {
    RunStarted: ("run", "nodes"),
    RequirementChanged: ("requirement", "violated_at", "on_violation", "sources", "why"),
}
"""Fields that a trace leaves out: they differ from run to run, or repeat the mission."""


# ---- lines that are read ----------------------------------------------------------------------

Fields = Mapping[str, Any]
Indices = Mapping[str, int]


def knows(name: str) -> bool:
    """Return whether a name is that of an event in a line of a trace or of ``~/log``."""
    return name in READERS or name in KINDS


def is_of_log(name: str) -> bool:
    """Return whether a name is that of an event that ``~/log`` carries."""
    return name in KINDS and KINDS[name].event_topic == "log"


def event_of(fields: Fields, indices: Indices) -> Event | None:
    """Return the event of a line of a trace or of ``~/log``; None for an unknown one.

    Fields that a trace omits are empty.

    Args:
        fields: The fields of the line.
        indices: The indices of the nodes by path.

    Raises:
        LookupError: A line lacks a field, or names a node that is not in the tree.
        ValueError: A value is not possible.
    """
    name = fields.get("event", "")
    if (read := READERS.get(name)) is not None:
        return read(fields, indices)
    return _read_plain(fields, indices) if name in KINDS else None


def _read_plain(fields: Fields, _: Indices) -> Event:
    node = {"node": fields["index"]} if "index" in fields else {}
    return _adapter(fields["event"]).validate_python({**fields, **node, "time_ns": fields["t"]})


@cache
def _adapter(name: str) -> TypeAdapter[Event]:
    return TypeAdapter(KINDS[name])


def _started_of(fields: Fields, _: Indices) -> RunStarted:
    world, robot, seed = fields["world"], fields["robot"], fields["seed"]
    return RunStarted(fields["t"], "", fields["mission"], (), world, robot, seed)


def _revised_of(fields: Fields, _: Indices) -> TreeRevised:
    nodes = tuple(NodeInfo(**node) for node in fields["nodes"])
    mission, kept = fields["mission"], tuple(fields["kept"])
    return TreeRevised(
        fields["t"],
        "",
        mission,
        nodes,
        kept,
        fields["number"],
        fields["summary"],
        cycle=fields["cycle"],
        keep_goals=fields["keep_goals"],
    )


def _goal_of(fields: Fields, _: Indices) -> GoalChanged:
    state, status = fields["phase"], fields["status"]
    if state == "ended":
        state = "rejected" if status is None else GoalStatus(status).name.lower()
    change = fields["event"].removeprefix("goal ")
    goal, action, owner = (str(fields[name]) for name in ("goal", "action", "owner"))
    return GoalChanged(fields["t"], goal, action, owner, 0, state, change)


def _state_of(fields: Fields, _: Indices) -> StateChanged:
    name, reason = fields["event"], fields.get("reason", "")
    changed = StateChanged(fields["t"], "", "", fields.get("status", name), reason)
    match name:
        case "resumed":
            return replace(changed, status="running")
        case "paused":
            return replace(changed, keep_goals=fields["keep_goals"])
        case "observing":
            end = fields["status"]
            return replace(changed, status=name, verdict=end, observe_s=fields["seconds"])
    return changed


def _requirement_of(fields: Fields, _: Indices) -> RequirementChanged:
    name, verdict, margin = fields["name"], fields["verdict"], fields["margin"]
    known = (fields["t"], name, "", verdict, margin, fields["unit"], fields["at"])
    return RequirementChanged(*known, None, "", (), "", "")


READERS: Mapping[str, Callable[[Fields, Indices], Event]] = {
    "start": _started_of,
    "revised": _revised_of,
    "status": lambda fields, indices: NodeChanged(
        fields["t"], indices[fields["path"]], Status(fields["status"]), fields["message"]
    ),
    "reset": lambda fields, indices: NodesReset(
        fields["t"], tuple(indices[path] for path in fields["paths"])
    ),
    **dict.fromkeys(
        (f"goal {phase}" for phase in ("sent", "found again", "released", "abandoned", "ended")),
        _goal_of,
    ),
    **dict.fromkeys(("mission", "paused", "resumed", "observing"), _state_of),
    "requirement": _requirement_of,
    "fault": lambda fields, _: _read_plain({**fields, "parameters": fields.get("with")}, _),
}
"""Readers of lines that are not read by their fields."""


# ---- fields -----------------------------------------------------------------------------------


def phase_of(event: GoalChanged) -> str:
    """Return the phase of a goal, without the way in which it ended."""
    return "ended" if event.is_ended else event.state


def status_of(event: GoalChanged) -> int | None:
    """Return the final status as in ``action_msgs/msg/GoalStatus``; None before the end."""
    status = GOAL_STATUS.get(event.state)
    return None if status is None else int(status)


def _value(text: str) -> Any:
    """Return a variable's value; if it was cut, or JSON lacks it, its text."""
    try:
        return json.loads(text, parse_constant=lambda _: _not_json())
    except ValueError:
        return text


def _not_json() -> Any:
    raise ValueError
