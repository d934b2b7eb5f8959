"""Goals against what is known of our action servers, of the robot, and of units."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

from action_servers.core.goal_rules import ACTIONS
from action_servers.core.goal_rules import GoalRules as ActionRules
from action_servers.core.limits import Limit, NumberLimit
from action_servers.core.tuning import TUNING, Tuning
from bt_mission.core.diagnostics import Diagnostic
from bt_mission.core.robot.model import RobotModel
from bt_mission.core.stamps import NS
from bt_mission.core.yaml.document import Document
from bt_mission.language.checks.rules import Ranges
from bt_mission.language.nodes.base import Path
from bt_mission.language.nodes.interfaces import InterfaceNode

_AXES = ("x", "y", "z")
"""What the numbers of a point stand for that is written as a list."""

_STEP_DEG = 15.0
_NEAR_DEG = 0.1
"""An angle in radians is told by being a multiple of 15 degrees but for this much."""


@dataclass(frozen=True)
class ServerSettings:
    """Parameters of the action servers, as far as it depends on them what goals they refuse.

    Args:
        tuning: Their limits.
        velocities: Highest speeds that they drive at, by the robot's names, where these are lower.
        offered: The actions that are theirs; None is all that they have.
    """

    tuning: Tuning = TUNING
    velocities: Mapping[str, float] | None = None
    offered: frozenset[str] | None = None


OUR_SERVERS = ServerSettings()
"""The servers as they are started without any parameters."""


class ServerGoalRules:
    """What the action servers accept of goals, for one robot.

    Goals of actions that are not theirs are not judged.
    """

    def __init__(self, robot: RobotModel, settings: ServerSettings = OUR_SERVERS) -> None:
        self._robot = robot.model_copy(update=dict(settings.velocities or {}))
        self._settings = settings

    def faults(
        self, document: Document, node: InterfaceNode, values: Mapping[str, Any]
    ) -> Iterator[Diagnostic]:
        """Yield why our servers refuse a goal, and numbers that look as if of another unit."""
        rules = self._rules(node)
        if rules is None:
            return
        refused = False
        for limit in rules.limits(self._robot, self._settings.tuning):
            value = _value(values, limit.field)
            why = None if value is None else limit.fault(value)
            if why is not None:
                refused = True
                yield self._refusal(document, node, limit, why, value)
            elif value is not None and isinstance(limit, NumberLimit):
                yield from _suspicion(document, node, limit, value)
        misfit = None if refused or _has_unknown(values) else rules.misfit(_as_goal(values))
        if misfit is not None:
            path = (*node.path, *node.sent_path)
            message = f"{misfit}: the server of {node.ros_name} does not carry that out"
            yield document.fault(path, message)

    def feedback(self, node: InterfaceNode, values: Mapping[str, Any]) -> Ranges:
        """Return from where to where the feedback can go; nothing where the goal is not known."""
        rules = self._rules(node)
        return {} if rules is None or _has_unknown(values) else rules.feedback(_as_goal(values))

    def _rules(self, node: InterfaceNode) -> ActionRules | None:
        """Return the rules for the goals of a node, if its action is one of ours."""
        name = node.ros_name.rpartition("/")[2]
        offered = self._settings.offered
        rules = ACTIONS.get(name) if offered is None or name in offered else None
        return rules if rules is not None and rules.type == node.type else None

    def _refusal(
        self, document: Document, node: InterfaceNode, limit: Limit, why: str, value: Any
    ) -> Diagnostic:
        source = limit.source.replace("the robot", f"the robot '{self._robot.name}'")
        path = _path(node, limit.field)
        if limit.field.partition(".")[0] not in node.sent:
            why = f"{limit.field} is missing, so it is {value!r}, and it must be {limit.words}"
        message = f"{why}: the server of {node.ros_name} refuses that (limit: {source})"
        hint = _in_degrees(limit, value) if isinstance(limit, NumberLimit) else None
        return document.fault(path, message, hint)


def _value(values: Mapping[str, Any], dotted: str) -> Any:
    """Return a field of a goal, a duration in seconds; None where only the run can tell."""
    found: Any = values
    for name in dotted.split("."):
        found = None if found is None else found[name]
    if isinstance(found, Mapping):
        return None if _has_unknown(found) else found["sec"] + found["nanosec"] / NS
    return found


def _path(node: InterfaceNode, dotted: str) -> Path:
    """Return where a field stands, also where a point is written as a list."""
    path: Path = (*node.path, *node.sent_path)
    written: Any = node.sent
    for name in dotted.split("."):
        if isinstance(written, Mapping) and name in written:
            path, written = (*path, name), written[name]
        elif isinstance(written, tuple | list) and name in _AXES:
            path = (*path, _AXES.index(name))
    return path


def _has_unknown(value: Any) -> bool:
    match value:
        case Mapping():
            return any(_has_unknown(part) for part in value.values())
        case list() | tuple():
            return any(_has_unknown(part) for part in value)
    return value is None


def _as_goal(value: Any) -> Any:
    """Return the fields of a goal as the attributes that its message has."""
    if isinstance(value, Mapping):
        return SimpleNamespace(**{name: _as_goal(part) for name, part in value.items()})
    return [_as_goal(part) for part in value] if isinstance(value, list | tuple) else value


def _suspicion(
    document: Document, node: InterfaceNode, limit: NumberLimit, value: float
) -> Iterator[Diagnostic]:
    """Yield a warning for an angle that is accepted but looks as if it was of another unit."""
    path = _path(node, limit.field)
    if limit.unit == "deg" and is_like_radians(value):
        degrees = round(math.degrees(value) / _STEP_DEG) * _STEP_DEG
        message = f"'{limit.field}' is in degrees, and {value:g} looks like {degrees:g} of them"
        hint = f"for {degrees:g} degrees write {degrees:g}"
        yield document.fault(path, f"{message} in radians", hint, severity="warning")
    elif limit.unit == "rad" and is_like_degrees(value):
        turns = abs(value) / math.tau
        message = f"'{limit.field}' is in radians, and {value:g} of them are {turns:.1f} turns"
        yield document.fault(path, message, _in_degrees(limit, value), severity="warning")


def is_like_radians(value: float) -> bool:
    """Return whether a number of degrees looks like a usual angle in radians, such as 1.5708."""
    degrees = math.degrees(value)
    steps = round(degrees / _STEP_DEG)
    is_whole = abs(value - round(value)) < 1e-3
    return (
        steps != 0
        and abs(value) <= math.tau + 0.01
        and not is_whole
        and (abs(degrees - steps * _STEP_DEG) < _NEAR_DEG)
    )


def is_like_degrees(value: float) -> bool:
    """Return whether a number of radians looks like a usual angle in degrees, such as 90."""
    return abs(value) >= _STEP_DEG and value % _STEP_DEG == 0


def _in_degrees(limit: NumberLimit, value: float) -> str | None:
    """Return how the same number of degrees is written in a field in radians."""
    if limit.unit == "rad" and is_like_degrees(value):
        return f"for {value:g} degrees write '{value:g} * pi / 180'"
    in_radians = math.radians(value)
    if limit.unit == "rad/s" and abs(value) > limit.high and limit.fault(in_radians) is None:
        return f"for {value:g} degrees a second write {in_radians:.4g}"
    return None


def with_parameters(parameters: Mapping[str, Any], offered: frozenset[str]) -> ServerSettings:
    """Return the settings of servers that run, from the parameters of their node."""
    known = {name: value for name, value in parameters.items() if name in TUNING.__slots__}
    velocities = {
        name: parameters[name]
        for name in ("max_linear_velocity", "max_angular_velocity")
        if name in parameters
    }
    return ServerSettings(replace(TUNING, **known), velocities, offered)
