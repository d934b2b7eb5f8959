"""Events as lines of JSON, and back: of a trace, of ``watch --json``.

A line is one JSON object with sorted keys: ``t`` is ROS time, ns; ``event`` names the event; nodes
are given by name and path. Floats are written so that they read back exactly. A trace has the
events that follow from mission and seed alone, and of those only such fields.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from py_trees.common import Status

from bt_mission.events.events import (
    FINAL,
    BreakpointsChanged,
    ClockJumped,
    CountsChanged,
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
    VariableChanged,
)
from bt_mission.goals.goal import GoalStatus

_ENCODER = json.JSONEncoder(sort_keys=True)  # json.dumps makes a new one for each event
_text = json.encoder.encode_basestring_ascii  # what the encoder writes a text with

GOAL_STATUS = {
    "succeeded": GoalStatus.SUCCEEDED,
    "canceled": GoalStatus.CANCELED,
    "aborted": GoalStatus.ABORTED,
    "unknown": GoalStatus.UNKNOWN,
}
"""Status of the goal's result, by the state in which a goal has ended; a rejected one has none."""

Nodes = Sequence[NodeInfo]


def fields_of(event: Event, nodes: Nodes = ()) -> dict[str, Any]:
    """Return the fields of an event by name, ready for JSON.

    Args:
        nodes: Of the tree that the event's indices refer to.
    """
    return {**FIELDS[type(event)](event, nodes), "t": event.time_ns}


def _started(event: RunStarted, _: Nodes) -> dict[str, Any]:
    shown = ("name", "kind", "path", "parent")
    return {
        "event": "start",
        "run": event.run,
        "mission": event.mission,
        "world": event.world,
        "robot": event.robot,
        "seed": event.seed,
        "nodes": [{name: getattr(one, name) for name in shown} for one in event.nodes],
    }


def _node(index: int, nodes: Nodes) -> dict[str, Any]:
    return {"node": nodes[index].name, "path": nodes[index].path}


def _changed(event: NodeChanged, nodes: Nodes) -> dict[str, Any]:
    status = {"status": event.status.value, "message": event.message}
    return {"event": "status", **_node(event.node, nodes), **status}


def _progressed(event: NodeProgressed, nodes: Nodes) -> dict[str, Any]:
    fields = {"event": "progress", **_node(event.node, nodes)}
    fields |= {"since": event.since_ns, "message": event.message}
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
    fields = {"event": "mission", "run": event.run, "mission": event.mission}
    return {**fields, "status": event.status, "reason": event.explanation}


def _requirement(event: RequirementChanged, _: Nodes) -> dict[str, Any]:
    return {
        "event": "requirement",
        "name": event.name,
        "requirement": event.requirement,
        "verdict": event.verdict,
        "margin": event.margin,
        "unit": event.unit,
        "at": event.at,
        "violated_at": event.violated_at,
        "on_violation": event.on_violation,
        "sources": event.sources,
        "why": event.why,
    }


def _fault(event: FaultChanged, _: Nodes) -> dict[str, Any]:
    fields = {"event": "fault", "number": event.number, "what": event.what, "state": event.state}
    return fields if event.parameters is None else {**fields, "with": event.parameters}


def _pose(event: PoseSampled, _: Nodes) -> dict[str, Any]:
    at = {"x": event.x, "y": event.y, "yaw": event.yaw}
    return {"event": "pose", **at, "collisions": event.collisions}


FIELDS: Mapping[type, Callable[[Any, Nodes], dict[str, Any]]] = {
    RunStarted: _started,
    NodeChanged: _changed,
    NodesReset: lambda event, nodes: {
        "event": "reset",
        "paths": [nodes[index].path for index in event.nodes],
    },
    NodeProgressed: _progressed,
    GoalChanged: _goal,
    VariableChanged: lambda event, _: {
        "event": "variable",
        "name": event.name,
        "value": _value(event.value),
    },
    StateChanged: _state,
    CountsChanged: lambda event, _: {
        "event": "counts",
        "ticks": event.ticks,
        "goals_sent": event.goals_sent,
    },
    BreakpointsChanged: lambda event, _: {"event": "breakpoints", "nodes": event.names},
    LogLine: lambda event, _: {"event": "log", "text": event.text},
    RequirementChanged: _requirement,
    ClockJumped: lambda event, _: {"event": "clock", "jump": event.jump_s},
    FaultChanged: _fault,
    PoseSampled: _pose,
}
"""The name and the fields of each event."""


def json_line(event: Event, nodes: Nodes = ()) -> str:
    """Return an event as a line of JSON.

    ``t`` is null where only the present is known, since the reader came later.
    """
    return json.dumps(fields_of(event, nodes), sort_keys=True, allow_nan=False)


# ---- traces -----------------------------------------------------------------------------------


def trace_line(event: Event, nodes: Nodes, names: Sequence[str]) -> str | None:
    """Return the line of an event in a trace; None for an event that a trace does not have.

    Args:
        names: For each node, its name and path as :func:`node_names` writes them.
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
        case _ if (is_traced := TRACED.get(type(event))) is not None and is_traced(event):
            fields = fields_of(event, nodes)
            for name in ONLY_LIVE.get(type(event), ()):
                fields.pop(name, None)
            return _ENCODER.encode(fields)
    return None


def goal_line(event: GoalChanged, goal: str) -> str:
    """Return the line of a goal in a trace, with this in the place of its id."""
    status = status_of(event)
    return (
        f'{{"action": {_text(event.action)}, "event": {_text(f"goal {event.change}")},'
        f' "goal": {goal}, "owner": {_text(event.owner)}, "phase": {_text(phase_of(event))},'
        f' "status": {"null" if status is None else status}, "t": {event.time_ns}}}'
    )


def node_names(nodes: Nodes) -> tuple[str, ...]:
    """Return name and path of each node as they are written in lines of a trace."""
    return tuple(f'"node": {_text(one.name)}, "path": {_text(one.path)}' for one in nodes)


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


TRACED: Mapping[type, Callable[[Any], bool]] = {
    RunStarted: lambda event: event.world is not None,
    NodesReset: lambda _: True,
    LogLine: lambda event: event.is_own,
    RequirementChanged: lambda event: event.verdict == "violated" and not event.is_update,
    ClockJumped: lambda _: True,
    FaultChanged: lambda _: True,
    PoseSampled: lambda _: True,
}
"""Other events of a trace, and which of them."""

ONLY_LIVE: Mapping[type, tuple[str, ...]] = {
    RunStarted: ("run", "nodes"),
    RequirementChanged: ("requirement", "violated_at", "on_violation", "sources", "why"),
}
"""Fields that a trace leaves out: they differ from run to run, or repeat the mission."""


# ---- lines of a trace, read --------------------------------------------------------------------

Fields = Mapping[str, Any]
Indices = Mapping[str, int]


def event_of(fields: Fields, indices: Indices) -> Event | None:
    """Return the event of a line of a trace; None for one that is not known here.

    What a trace leaves out is empty.

    Args:
        fields: Of the line.
        indices: Those of the nodes, by their paths.

    Raises:
        LookupError: For a line that lacks a field, or names a node that is not in the tree.
        ValueError: For a value that does not exist.
    """
    read = TRACE_EVENTS.get(fields.get("event", ""))
    return None if read is None else read(fields, indices)


def _goal_of(fields: Fields, _: Indices) -> GoalChanged:
    phase, status = fields["phase"], fields["status"]
    if phase == "ended":
        phase = "rejected" if status is None else GoalStatus(status).name.lower()
    change = fields["event"].removeprefix("goal ")
    goal, action, owner = (str(fields[name]) for name in ("goal", "action", "owner"))
    return GoalChanged(fields["t"], goal, action, owner, 0, phase, change)


def _state_of(fields: Fields, _: Indices) -> StateChanged:
    time_ns, name = fields["t"], fields["event"]
    match name:
        case "mission":
            return StateChanged(time_ns, "", "", fields["status"], fields["reason"])
        case "resumed":
            return StateChanged(time_ns, "", "", "running", "")
        case "paused":
            keep = fields["keep_goals"]
            return StateChanged(time_ns, "", "", name, fields["reason"], keep_goals=keep)
    verdict, observe_s = fields["status"], fields["seconds"]
    return StateChanged(
        time_ns, "", "", name, fields["reason"], verdict=verdict, observe_s=observe_s
    )


def _requirement_of(fields: Fields, _: Indices) -> RequirementChanged:
    name, verdict, margin = fields["name"], fields["verdict"], fields["margin"]
    return RequirementChanged(
        *(fields["t"], name, "", verdict, margin, fields["unit"], fields["at"]),
        *(None, "", (), "", ""),
    )


def _start_of(fields: Fields, _: Indices) -> RunStarted:
    world, robot, seed = fields["world"], fields["robot"], fields["seed"]
    return RunStarted(fields["t"], "", fields["mission"], (), world, robot, seed)


TRACE_EVENTS: Mapping[str, Callable[[Fields, Indices], Event]] = {
    "start": _start_of,
    "status": lambda fields, indices: NodeChanged(
        fields["t"], indices[fields["path"]], Status(fields["status"]), fields["message"]
    ),
    "reset": lambda fields, indices: NodesReset(
        fields["t"], tuple(indices[path] for path in fields["paths"])
    ),
    **{
        f"goal {change}": _goal_of
        for change in ("sent", "found again", "released", "abandoned", "ended")
    },
    **dict.fromkeys(("mission", "paused", "resumed", "observing"), _state_of),
    "log": lambda fields, _: LogLine(fields["t"], fields["text"]),
    "requirement": _requirement_of,
    "clock": lambda fields, _: ClockJumped(fields["t"], fields["jump"]),
    "fault": lambda fields, _: FaultChanged(
        fields["t"], fields["number"], fields["what"], fields["state"], fields.get("with")
    ),
    "pose": lambda fields, _: PoseSampled(
        fields["t"], fields["x"], fields["y"], fields["yaw"], fields["collisions"]
    ),
}
"""How the events of a trace are read, by their names."""


# ---- fields -----------------------------------------------------------------------------------


def phase_of(event: GoalChanged) -> str:
    """Return the phase of a goal: how its end was does not count."""
    return "ended" if event.is_ended else event.state


def status_of(event: GoalChanged) -> int | None:
    """Return the number of the final status in ``action_msgs/msg/GoalStatus``; None before it."""
    status = GOAL_STATUS.get(event.state)
    return None if status is None else int(status)


def _value(text: str) -> Any:
    """Return a variable's value; one that was cut, or holds what JSON has not, as its text."""
    try:
        return json.loads(text, parse_constant=lambda _: _not_json())
    except ValueError:
        return text


def _not_json() -> Any:
    raise ValueError
