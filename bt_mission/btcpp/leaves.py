"""How the leaves of the mission language stand in XML: a tag for each kind, and its attributes.

The tag of a leaf is its kind, `<turn angle="90" timeout="30"/>`. Fields of a goal, a request or a
message are attributes, nested ones with `__` between the names; what a leaf gives to variables are
attributes that begin with `out_`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

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
    (
        "action",
        "cancel_when",
        "message",
        "on_cancel",
        "service",
        "target",
        "topic",
        "type",
        "until",
    )
)
"""Attributes, fields apart, that hold a text, whatever it looks like."""

_FIELD = re.compile(r"[a-z](?:_?[a-z0-9])*")


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

    @property
    def modifiers(self) -> tuple[str, ...]:
        """The modifiers that are attributes of the same name."""
        other = {self.kind, "outputs", "inputs", *NodeModel.keys}
        return tuple(name for name in KINDS[self.kind].keys if name not in other)

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

    def output_name(self, attribute: str) -> str:
        """Return what an `out_` attribute takes."""
        name = attribute.removeprefix(OUT)
        return name if self.named else name.replace(NESTED, ".")

    def output_attribute(self, name: str) -> str:
        """Return the `out_` attribute that takes this."""
        return OUT + (name if self.named else name.replace(".", NESTED))

    def field_path(self, attribute: str) -> tuple[str, ...] | None:
        """Return the names of the field that an attribute holds, or None."""
        if self.fields is None:
            return None
        if self.prefix and attribute.startswith(self.prefix):
            path = tuple(attribute.removeprefix(self.prefix).split(NESTED))
        elif self.is_short:
            path = tuple(attribute.split(NESTED))
        else:
            return None
        return path if all(_FIELD.fullmatch(name) for name in path) else None

    def field_attribute(self, path: tuple[str, ...]) -> str | None:
        """Return the attribute that holds a field, or None where no attribute can."""
        if not all(_FIELD.fullmatch(name) for name in path):
            return None
        name = NESTED.join(path)
        if not self.is_short:
            return self.prefix + name
        is_taken = name in self.modifiers or name == "name" or name.startswith((OUT, GOAL))
        return self.prefix + name if is_taken else name


LEAVES: dict[str, LeafElement] = {
    "check": LeafElement("check", whole="condition"),
    "set": LeafElement("set", named="set_"),
    "wait": LeafElement("wait", whole="seconds"),
    "log": LeafElement("log", whole="message"),
    "action": LeafElement(
        "action", settings={"action": "name", "type": "type"}, fields="goal", prefix=GOAL
    ),
    "service": LeafElement(
        "service",
        settings={"service": "name", "type": "type"},
        fields="request",
        prefix="request__",
    ),
    "wait_for": LeafElement(
        "wait_for", settings={"topic": "topic", "type": "type", "until": "until"}
    ),
    "publish": LeafElement(
        "publish",
        settings={"topic": "topic", "type": "type"},
        fields="message",
        prefix="message__",
    ),
    "python": LeafElement("python", whole="target", named="in_"),
    **{kind: LeafElement(kind, fields="", prefix=GOAL) for kind in ACTION_NAMES if kind in KINDS},
}
"""Every kind of leaf but `tree`, which is a SubTree."""


def flattened(value: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield the fields of a message that are no mappings, each with its path; empty ones, too."""
    if isinstance(value, dict) and (value or not path):
        for name, part in value.items():
            yield from flattened(part, (*path, name))
    else:
        yield path, value
