"""What a mission can be made of, for forms, completion and hover: kinds and their fields."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import cache
from typing import Any

from action_servers.core.action import action
from action_servers.core.limits import NumberLimit
from bt_mission.base.actions import declared
from bt_mission.base.diagnostics import InputError
from bt_mission.commands.edit.outline import outline
from bt_mission.commands.edit.source import LIST_KEYS, indented
from bt_mission.commands.edit.spans import read_spans
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.interface_units import PARTS, SI, interface_of, unit_of_field
from bt_mission.language.message_types import MessageShape, Scalar, UnknownType
from bt_mission.language.nodes.base import Family, NodeModel
from bt_mission.language.nodes.registry import KINDS
from bt_mission.requirements.schema import mission_schema
from bt_mission.robots.model import RobotModel, load_robot
from bt_mission.sessions.file_checks import DEFAULT_ROBOT
from bt_mission.sessions.load import installed_shapes

TEMPLATES: Mapping[str, str] = {
    "sequence": "sequence: []",
    "fallback": "fallback: []",
    "parallel": "parallel: []",
    "choose": "choose: []",
    "when": "when: $x > 0\ndo:",
    "finally": "finally: {timeout: 10}\ndo:\nthen:",
    "repeat": "repeat: {count: 3}\ndo:",
    "retry": "retry: {attempts: 3}\ndo:",
    "timeout": "timeout: 10\ndo:",
    "invert": "invert:",
    "force": "force: success\ndo:",
    "guard": "guard: $x > 0\ndo:",
    "for_each": "for_each: {item: [1, 2, 3]}\ndo:",
    "check": "check: $x > 0",
    "set": "set: {x: 0}",
    "wait": "wait: 1",
    "log": "log: here",
    "python": "python: my_leaf.py:MyLeaf",
    "service": "service: {name: /reset, type: std_srvs/srv/Trigger}\ntimeout: 5",
    "wait_for": "wait_for: {topic: /ready, type: std_msgs/msg/Bool, until: data}\ntimeout: 30",
    "publish": "publish: {topic: /hello, type: std_msgs/msg/String, message: {data: hello}}",
    "action": "action: {name: /dock, type: nav2_msgs/action/DockRobot}\ntimeout: 60",
    "tree": "tree: name",
}
"""A new node of each kind that is not the goal of an action with a short name."""

WRAPPERS = (
    *("sequence", "fallback", "parallel", "repeat", "retry", "timeout", "invert", "force"),
    *("guard", "when", "finally", "for_each", "choose"),
)
"""The kinds into which a node can be put, the most usual first."""

GOAL_TIMEOUT = 60
"""Seconds of a new goal: one without a limit is a warning."""


@dataclass(frozen=True)
class FieldFacts:
    """A field of a node or of a mission.

    Attributes:
        keys: Lead to it from the node.
        type: `number`, `integer`, `text`, `bool`, `options`, `condition`, or `yaml` for others.
        words: The accepted values, as text; empty if any are.
        default: As it is written; empty without one.
    """

    keys: tuple[str, ...]
    type: str
    unit: str = ""
    words: str = ""
    options: tuple[str, ...] = ()
    default: str = ""
    text: str = ""
    is_required: bool = False


@dataclass(frozen=True)
class KindFacts:
    """A kind of node.

    Attributes:
        template: A new node of it.
        wrapper: The value of its key around another node; None if it cannot be put around one.
    """

    kind: str
    family: str
    glyph: str
    text: str
    template: str
    wrapper: str | None
    children: tuple[str, ...]
    fields: tuple[FieldFacts, ...]
    results: tuple[str, ...] = ()
    feedback: tuple[str, ...] = ()


@cache
def kinds() -> Mapping[str, KindFacts]:
    """Return every kind of node by its key, the families together."""
    schema = mission_schema()
    robot = load_robot(DEFAULT_ROBOT)
    facts = [_kind(kind, model, schema, robot) for kind, model in KINDS.items()]
    order = [family.value for family in Family]
    facts.sort(key=lambda kind: (order.index(kind.family), kind.kind not in ACTION_NAMES))
    return {kind.kind: kind for kind in facts}


@cache
def mission_fields() -> tuple[FieldFacts, ...]:
    """Return the fields of a mission that a form shows."""
    schema = mission_schema()
    required = schema["required"]
    return tuple(
        _field((key,), part, is_required=key in required)
        for key, part in schema["properties"].items()
        if key not in ("tree", "trees")
    )


def as_json() -> dict[str, Any]:
    """Return all of it for a page."""
    return {
        "kinds": [asdict(facts) | {"boxes": _boxes(facts)} for facts in kinds().values()],
        "wrappers": list(WRAPPERS),
        "mission": [asdict(facts) for facts in mission_fields()],
    }


def _boxes(facts: KindFacts) -> list[dict[str, Any]]:
    """Return the boxes of a new node of a kind."""
    text = f"tree:\n  {indented(facts.template, 2)}"
    return [box.as_row() for box in outline(read_spans(text), text)[1:]]


def template_of(kind: str) -> str:
    """Return a new node of a kind."""
    if kind in TEMPLATES:
        return TEMPLATES[kind]
    known = ACTION_NAMES[kind]
    goal = ", ".join(f"{name}: {_written(value)}" for name, value in known.example.items())
    return f"{kind}: {{{goal}}}\ntimeout: {GOAL_TIMEOUT}"


def _written(value: object) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    return json.dumps(value) if not isinstance(value, str) else value


def _kind(
    kind: str, model: type[NodeModel], schema: Mapping[str, Any], robot: RobotModel
) -> KindFacts:
    definition = schema["$defs"][f"kind_{kind}"]
    template = template_of(kind)
    wrapper = None
    if kind in WRAPPERS:
        wrapper = template.split("\n", maxsplit=1)[0].partition(":")[2].strip()
    fields = list(_own_fields(kind, definition, schema, robot))
    modifiers = [key for key in model.keys if key not in (kind, *model.child_keys)]
    fields += [_modifier(model, key, definition["properties"][key]) for key in modifiers]
    sent = _shapes(kind)
    return KindFacts(
        kind,
        model.sign.family.value,
        model.sign.glyph,
        " ".join((model.__doc__ or "").split()),
        template,
        wrapper,
        ("*",) if kind in LIST_KEYS else model.child_keys,
        tuple(fields),
        tuple(sent.keeps.fields) if sent else (),
        tuple(sent.asks.fields) if sent and sent.asks else (),
    )


def _shapes(kind: str) -> Any:
    find = installed_shapes()
    if kind not in ACTION_NAMES or find is None:
        return None
    try:
        return find(ACTION_NAMES[kind].type)
    except UnknownType:
        return None


def _own_fields(
    kind: str, definition: Mapping[str, Any], schema: Mapping[str, Any], robot: RobotModel
) -> Iterator[FieldFacts]:
    """Yield the fields below the key of a kind, or the one that it is itself."""
    if kind in LIST_KEYS or kind == "invert":
        return
    if kind in ACTION_NAMES:
        yield from _goal_fields(kind, robot)
        return
    part = definition["properties"][kind]
    if "$ref" in part:
        inner = schema["$defs"][part["$ref"].rpartition("/")[2]]
        for key, field in inner["properties"].items():
            required = key in inner.get("required", ())
            yield _field((kind, key), field, is_required=required)
        return
    model = KINDS[kind]
    yield _modifier(model, kind, part, is_required=True)


def _modifier(
    model: type[NodeModel], key: str, part: Mapping[str, Any], *, is_required: bool = False
) -> FieldFacts:
    """Return a key of a node, with the rule of its number."""
    field = _field((key,), part, is_required=is_required)
    rule = next((mark.wanted for path, _, mark in model.read_fields if path == (key,)), None)
    if rule is None or isinstance(rule, str):
        unit = "s" if key.endswith("timeout") else ""
        return FieldFacts(**{**asdict(field), "unit": unit})
    return FieldFacts(**{**asdict(field), "unit": rule.unit, "words": rule.words})


def _field(
    keys: tuple[str, ...], part: Mapping[str, Any], *, is_required: bool = False
) -> FieldFacts:
    """Return a field by its schema."""
    options = _options(part)
    default = part.get("default")
    types = part.get("type", part.get("anyOf", [{}])[0].get("type", ""))
    types = types if isinstance(types, list) else [types]
    if options:
        kind = "options"
    elif "number" in types or "integer" in types:
        kind = "number" if "number" in types else "integer"
    elif types == ["boolean"]:
        kind, options = "bool", ("true", "false")
    elif types == ["string"]:
        kind = "condition" if keys[-1] in ("cancel_when", "until") else "text"
    elif "boolean" in types:
        kind = "condition"
    else:
        kind = "yaml"
    shown = "" if default in (None, "", [], {}) else json.dumps(default).strip('"')
    return FieldFacts(keys, kind, "", "", options, shown, part.get("description", ""), is_required)


def _options(part: Mapping[str, Any]) -> tuple[str, ...]:
    return tuple(part.get("enum", ())) or tuple(
        option for facts in part.get("anyOf", ()) for option in facts.get("enum", ())
    )


def _goal_fields(kind: str, robot: RobotModel) -> Iterator[FieldFacts]:
    """Yield the fields of a goal, with the units and limits that servers declare."""
    sent = _shapes(kind)
    known = ACTION_NAMES[kind]
    limits = _limits(kind, robot)
    fields: Mapping[str, Any] = sent.sends.fields if sent else dict.fromkeys(known.example)
    for name, shape in fields.items():
        unit = unit_of_field(known.type, "goal", (name,)) or ""
        limit = limits.get(name)
        remark = interface_of(known.type).section(PARTS["goal"]).remark(name)
        yield FieldFacts(
            (kind, name),
            _type_of(shape),
            "" if unit == SI else unit,
            "" if limit is None else limit.words,
            text=remark.text,
            is_required=next(iter(known.example), None) == name,
        )


def _type_of(shape: object) -> str:
    if isinstance(shape, Scalar):
        return {"number": "number", "integer": "integer", "bool": "bool"}.get(shape.type, "text")
    if isinstance(shape, MessageShape) and "Duration" in shape.name:
        return "number"
    return "yaml"


def _limits(kind: str, robot: RobotModel) -> dict[str, NumberLimit]:
    name = ACTION_NAMES[kind].name
    if name not in declared():
        return {}
    try:
        limits = action(name).limits_with(robot)
    except InputError:
        return {}
    return {
        limit.field: limit
        for limit in limits
        if isinstance(limit, NumberLimit) and math.isfinite(limit.low)
    }
