"""From a leaf as a YAML file has it to the attributes of its element."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from bt_mission.btcpp.attributes import written_text, written_value
from bt_mission.btcpp.leaves import TEXTS, LeafElement, flattened
from bt_mission.core.diagnostics import quoted
from bt_mission.language.nodes.base import Key

Path = tuple[Key, ...]
Refuse = Callable[[Path, str, str], None]
"""Told of a value that XML cannot say: where, what, and what to do."""


def write_leaf(
    leaf: LeafElement, data: dict[str, Any], path: Path, refuse: Refuse
) -> dict[str, str]:
    """Return the attributes of a leaf; what cannot be said is told to `refuse`."""
    attributes: dict[str, str] = {}
    if data.get("name"):
        attributes["name"] = data["name"]
    attributes |= _value(leaf, data[leaf.kind], (*path, leaf.kind), refuse)
    if leaf.whole and leaf.named:
        attributes |= {
            leaf.named + name: written_value(value)
            for name, value in data.get("inputs", {}).items()
        }
    for name in leaf.modifiers:
        if data.get(name) is not None:
            attributes[name] = _written(name, data[name])
    for name, variable in data.get("outputs", {}).items():
        attributes[leaf.output_attribute(name)] = f"{{{variable}}}"
    return attributes


def _value(leaf: LeafElement, value: Any, path: Path, refuse: Refuse) -> dict[str, str]:
    if leaf.whole is not None:
        return {leaf.whole: _written(leaf.whole, value)}
    if leaf.named:
        return {leaf.named + name: written_value(one) for name, one in value.items()}
    attributes = {
        attribute: _written(attribute, value[key]) for attribute, key in leaf.settings.items()
    }
    if leaf.fields is not None:
        inside = path if leaf.is_short else (*path, leaf.fields)
        fields = value if leaf.is_short else value.get(leaf.fields, {})
        attributes |= dict(_fields(leaf, fields, inside, refuse))
    return attributes


def _fields(
    leaf: LeafElement, fields: Any, path: Path, refuse: Refuse
) -> Iterator[tuple[str, str]]:
    for inner, value in flattened(fields):
        attribute = leaf.field_attribute(inner)
        if isinstance(value, dict) and inner:
            refuse((*path, *inner), "an empty message", "leave it out: it means the same")
        elif attribute is None:
            shown = quoted(".".join(inner))
            message = f"{shown}: no field of a ROS type has such a name"
            refuse((*path, *inner), message, "see 'bt-mission check'")
        elif inner:
            yield attribute, written_value(value)


def _written(attribute: str, value: Any) -> str:
    return written_text(value) if attribute in TEXTS else written_value(value)
