"""How the leaves of the mission language stand in XML: a tag for each kind, and its attributes.

The tag of a leaf is its kind, `<turn angle="90" timeout="30"/>`. Fields of a goal, a request or a
message are attributes, nested ones with `__` between the names; what a leaf gives to variables are
attributes that begin with `out_`. `LeafElement` tells for each attribute where its value stands in
a node, and the other way round; `read_leaf` and `write_leaf` go by it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

from bt_mission.btcpp.attributes import (
    AS_IT_IS,
    NAME,
    TEXT,
    VALUE,
    VARIABLE,
    Codec,
    Entry,
    FaultReport,
    LocatedValue,
    located,
    mapping,
    refuse_attribute,
)
from bt_mission.btcpp.elements import Element
from bt_mission.core.diagnostics import quoted
from bt_mission.core.yaml.composer import At
from bt_mission.core.yaml.document import Key
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.nodes.base import NodeModel
from bt_mission.language.nodes.registry import KINDS

OUT = "out_"
"""Begins the attributes that name a variable for something that a leaf gives."""

NESTED = "__"
"""Stands between the names of nested fields; no ROS field has it in its name."""

GOAL = "goal__"
"""May stand before the fields of a goal, and must where a modifier has the same name."""

TEXTS = frozenset(
    {"action", "cancel_when", "message", "on_cancel", "service", "target", "topic", "type", "until"}
)
"""Attributes, fields apart, that hold a text, whatever it looks like."""

_FIELD = re.compile(r"[a-z](?:_?[a-z0-9])*")

Path = tuple[Key, ...]
Names = tuple[str, ...]
Refuse = Callable[[Path, str, str], None]
"""Told of a value that XML cannot say: where, what, and what to do."""

Group = Literal["whole", "settings", "fields", "named", "modifiers", "outputs"]
"""The part of a node that an attribute belongs to: see `LeafElement`."""


@dataclass(frozen=True)
class LeafElement:
    """The attributes of one kind of leaf.

    `whole` is the attribute that holds the kind's value, `settings` are those that hold a part of
    it, each with its key. `fields` is the key of the fields of a message ("" where they are the
    value), `prefix` stands before their names. `named` stands before names of variables or
    attributes, which are the value, or the modifier `inputs` where there is a `whole`.
    """

    kind: str
    whole: str | None = None
    settings: Mapping[str, str] = field(default_factory=dict)
    fields: str | None = None
    prefix: str = ""
    named: str = ""

    @cached_property
    def modifiers(self) -> tuple[str, ...]:
        """The modifiers that are attributes of the same name."""
        other = {self.kind, "outputs", "inputs", *NodeModel.keys}
        return tuple(name for name in KINDS[self.kind].keys if name not in other)

    @cached_property
    def _fixed(self) -> dict[str, tuple[Group, Names]]:
        """Where the values of the attributes with fixed names stand."""
        found: dict[str, tuple[Group, Names]] = {
            name: ("modifiers", (name,)) for name in self.modifiers
        }
        found |= {name: ("settings", (key,)) for name, key in self.settings.items()}
        if self.whole is not None:
            found[self.whole] = ("whole", (self.kind,))
        return {**found, "name": ("modifiers", ("name",))}

    @property
    def gives(self) -> bool:
        """Whether it takes `out_` attributes."""
        return "outputs" in KINDS[self.kind].keys

    @property
    def is_short(self) -> bool:
        """Whether fields stand without a prefix."""
        return self.fields == ""

    @property
    def known(self) -> tuple[str, ...]:
        """The attributes with fixed names, and how the others begin."""
        names = [*([self.whole] if self.whole else []), *self.settings]
        if self.fields is not None:
            names.append("fields of the goal" if self.is_short else f"{self.prefix}FIELD")
        if self.named:
            names.append(f"{self.named}NAME")
        return (*names, *self.modifiers, *([f"{OUT}FIELD"] if self.gives else []), "name")

    def target(self, attribute: str) -> tuple[Group, Names] | None:
        """Return where in a node the value of an attribute stands, or None for an unknown one."""
        if attribute in self._fixed:
            return self._fixed[attribute]
        if self.gives and attribute.startswith(OUT):
            name = attribute.removeprefix(OUT)
            return "outputs", (name if self.named else name.replace(NESTED, "."),)
        if self.named and attribute.startswith(self.named):
            name = attribute.removeprefix(self.named)
            return ("named", (name,)) if NAME.fullmatch(name) else None
        if self.fields is None or not (self.is_short or attribute.startswith(self.prefix)):
            return None
        path = tuple(attribute.removeprefix(self.prefix).split(NESTED))
        return ("fields", path) if all(_FIELD.fullmatch(name) for name in path) else None

    def output_attribute(self, name: str) -> str:
        """Return the attribute that `target` takes for this output."""
        return OUT + (name if self.named else name.replace(".", NESTED))

    def field_attribute(self, path: Names) -> str | None:
        """Return the attribute that `target` takes for a field, or None where no attribute can."""
        if not all(_FIELD.fullmatch(name) for name in path):
            return None
        name = NESTED.join(path)
        if not self.is_short:
            return self.prefix + name
        is_taken = name in self.modifiers or name == "name" or name.startswith((OUT, GOAL))
        return self.prefix + name if is_taken else name


LEAVES: dict[str, LeafElement] = {
    leaf.kind: leaf
    for leaf in (
        LeafElement("check", whole="condition"),
        LeafElement("set", named="set_"),
        LeafElement("wait", whole="seconds"),
        LeafElement("log", whole="message"),
        LeafElement("action", None, {"action": "name", "type": "type"}, "goal", GOAL),
        LeafElement("service", None, {"service": "name", "type": "type"}, "request", "request__"),
        LeafElement("wait_for", None, {one: one for one in ("topic", "type", "until")}),
        LeafElement("publish", None, {"topic": "topic", "type": "type"}, "message", "message__"),
        LeafElement("python", whole="target", named="in_"),
        *(LeafElement(kind, fields="", prefix=GOAL) for kind in ACTION_NAMES if kind in KINDS),
    )
}
"""Every kind of leaf but `tree`, which is a SubTree."""


def _codec(group: Group, attribute: str) -> Codec:
    """Return how a value of a group stands in an attribute."""
    if group in ("fields", "named"):
        return VALUE
    if group == "outputs":
        return VARIABLE
    return AS_IT_IS if attribute == "name" else TEXT if attribute in TEXTS else VALUE


# ---- from an element ------------------------------------------------------------------------


@dataclass
class _Gathered:
    """A mapping as it is gathered from attributes."""

    at: At
    parts: dict[str, tuple[At, LocatedValue | _Gathered]] = field(default_factory=dict)

    def put(self, path: Names, at: At, part: LocatedValue) -> bool:
        """Put a value at a path; return whether that place was free."""
        name, *rest = path
        if not rest:
            is_free = name not in self.parts
            self.parts[name] = (at, part)
            return is_free
        _, inner = self.parts.setdefault(name, (at, _Gathered(at)))
        return isinstance(inner, _Gathered) and inner.put(tuple(rest), at, part)

    def entries(self) -> list[Entry]:
        """Return what is in it."""
        return [
            (name, at, inner if isinstance(inner, LocatedValue) else inner.value())
            for name, (at, inner) in self.parts.items()
        ]

    def value(self) -> LocatedValue:
        """Return the mapping."""
        return mapping(self.at, self.entries())


def read_leaf(leaf: LeafElement, element: Element, report: FaultReport) -> LocatedValue:
    """Return a leaf as the node of a mission; what is wrong with it is reported."""
    at = element.at
    for child in element.children:
        report(child.at, f"<{element.tag}> is a leaf, with nothing in it")
    groups: dict[Group, _Gathered] = {}
    for attribute in element.attributes.values():
        target = leaf.target(attribute.name)
        if target is None:
            refuse_attribute(attribute, leaf.kind, leaf.known, report)
            continue
        group, path = target
        value = _codec(group, attribute.name).read(attribute, report)
        is_free = groups.setdefault(group, _Gathered(at)).put(path, attribute.at, value)
        if group == "fields" and not is_free:
            report(attribute.at, f"the field {quoted('.'.join(path))} is given twice")
    found = {group: gathered.entries() for group, gathered in groups.items()}
    return mapping(at, _node(leaf, found, at, report))


def _node(
    leaf: LeafElement, found: Mapping[Group, list[Entry]], at: At, report: FaultReport
) -> Iterator[Entry]:
    """Yield the entries of the node that groups of attributes make."""
    value = [*found.get("settings", ())]
    fields, named = found.get("fields", []), found.get("named", [])
    if leaf.whole is not None and "whole" not in found:
        report(at, f"the attribute '{leaf.whole}' is missing")
        yield leaf.kind, at, located("", at)
    elif leaf.whole is not None:
        yield leaf.kind, at, found["whole"][0][2]
    elif leaf.is_short or leaf.named:
        yield leaf.kind, at, mapping(at, fields or named)
    else:
        if leaf.fields and fields:
            value.append((leaf.fields, at, mapping(at, fields)))
        yield leaf.kind, at, mapping(at, value)
    yield from found.get("modifiers", ())
    if leaf.whole and named:
        yield "inputs", named[0][1], mapping(at, named)
    if "outputs" in found:
        yield "outputs", found["outputs"][0][1], mapping(at, found["outputs"])


# ---- to an element --------------------------------------------------------------------------


def write_leaf(
    leaf: LeafElement, data: dict[str, Any], path: Path, refuse: Refuse
) -> dict[str, str]:
    """Return the attributes of a leaf; what cannot be said is told to `refuse`."""
    return {
        attribute: _codec(group, attribute).write(value)
        for group, attribute, value in _attributes(leaf, data, path, refuse)
    }


def _attributes(
    leaf: LeafElement, data: dict[str, Any], path: Path, refuse: Refuse
) -> Iterator[tuple[Group, str, Any]]:
    """Yield the attributes of a leaf: to which group each belongs, its name, and its value."""
    if data.get("name"):
        yield "modifiers", "name", data["name"]
    value = data[leaf.kind]
    if leaf.whole is not None:
        yield "whole", leaf.whole, value
    for attribute, key in leaf.settings.items():
        if key in value:  # else it is as by default, in XML, too
            yield "settings", attribute, value[key]
    if leaf.fields is not None:
        yield from _fields(leaf, value, (*path, leaf.kind), refuse)
    if leaf.named:
        named = data.get("inputs", {}) if leaf.whole else value
        yield from (("named", leaf.named + name, one) for name, one in named.items())
    said = {name: data.get(name) for name in leaf.modifiers}
    yield from (("modifiers", name, one) for name, one in said.items() if one is not None)
    for name, variable in data.get("outputs", {}).items():
        yield "outputs", leaf.output_attribute(name), variable


def _fields(
    leaf: LeafElement, value: Any, path: Path, refuse: Refuse
) -> Iterator[tuple[Group, str, Any]]:
    if leaf.fields:
        value, path = value.get(leaf.fields, {}), (*path, leaf.fields)
    for inner, one in _flattened(value):
        attribute = leaf.field_attribute(inner)
        if isinstance(one, dict) and inner:
            refuse((*path, *inner), "an empty message", "leave it out: it means the same")
        elif attribute is None:
            message = f"{quoted('.'.join(inner))}: no field of a ROS type has such a name"
            refuse((*path, *inner), message, "see 'bt-mission check'")
        elif inner:
            yield "fields", attribute, one


def _flattened(value: Any, path: Names = ()) -> Iterator[tuple[Names, Any]]:
    """Yield the fields of a message that are no mappings, each with its path; empty ones, too."""
    if isinstance(value, dict) and (value or not path):
        for name, part in value.items():
            yield from _flattened(part, (*path, name))
    else:
        yield path, value
