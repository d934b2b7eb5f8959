"""The `TreeNodesModel` of our leaves, from which Groot 2 learns their ports."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping

from bt_mission.btcpp.document import FORMAT
from bt_mission.btcpp.elements import Tag, xml_text
from bt_mission.btcpp.leaves import LEAVES, OUT, TEXTS, LeafElement
from bt_mission.btcpp.ports import LABELS
from bt_mission.core.errors import BtMissionError
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.message_types import (
    ActionShapes,
    ListOf,
    MessageShape,
    Scalar,
    ServiceShapes,
    Shape,
)

ShapesOf = Callable[[str], ActionShapes | ServiceShapes | MessageShape]
"""Tells what a ROS type holds. Raises UnknownType."""

_CONDITIONS = frozenset(("check",))


def palette_xml(shapes: ShapesOf | None = None) -> str:
    """Return the models of all leaves, as a file without a tree, for Groot 2 to load."""
    models = Tag("TreeNodesModel", {}, tuple(leaf_models(dict.fromkeys(LEAVES, ()), shapes)))
    return xml_text(Tag("root", {"BTCPP_format": FORMAT}, (models,)))


def leaf_models(used: Mapping[str, Iterable[str]], shapes: ShapesOf | None = None) -> Iterator[Tag]:
    """Yield the models of leaves, by kind; those attributes are listed as well that are `used`."""
    for kind, attributes in used.items():
        ports = _ports(LEAVES[kind], shapes)
        for attribute in attributes:
            if attribute != "name":
                ports.setdefault(attribute, _port(attribute, "" if attribute in TEXTS else None))
        tag = "Condition" if kind in _CONDITIONS else "Action"
        yield Tag(tag, {"ID": kind}, tuple(ports.values()))


def _ports(leaf: LeafElement, shapes: ShapesOf | None) -> dict[str, Tag]:
    """Return the ports of a leaf that are known without a mission, by name."""
    ports: dict[str, Tag] = {}
    if leaf.whole:
        ports[leaf.whole] = _port(leaf.whole)
    for name in leaf.settings:
        ports[name] = _port(name)
    talk = action_shapes(leaf, shapes)
    if talk is not None:
        for name, shape in talk.goal.fields.items():
            attribute = leaf.field_attribute((name,))
            if attribute is not None:
                ports[attribute] = _port(attribute, _label(shape))
    for name in leaf.modifiers:
        ports[name] = _port(name)
    if talk is not None:
        for name, shape in talk.result.fields.items():
            attribute = leaf.output_attribute(name)
            ports[attribute] = _port(attribute, _label(shape))
    return ports


def action_shapes(leaf: LeafElement, shapes: ShapesOf | None) -> ActionShapes | None:
    """Return what the type of an action with a short name holds, as far as that is known."""
    if shapes is None or leaf.kind not in ACTION_NAMES:
        return None
    try:
        found = shapes(ACTION_NAMES[leaf.kind].type)
    except BtMissionError:  # a type that is not installed: the attributes in use will do
        return None
    return found if isinstance(found, ActionShapes) else None


def _port(name: str, label: str | None = None) -> Tag:
    direction = "output_port" if name.startswith(OUT) else "input_port"
    return Tag(direction, {"name": name, **({"type": label} if label else {})})


def _label(shape: Shape) -> str | None:
    match shape:
        case Scalar():
            return LABELS[shape.type]
        case ListOf():
            return LABELS["list"]
    return None
