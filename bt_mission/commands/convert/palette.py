"""The `TreeNodesModel` of our leaves, from which Groot 2 learns their ports."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress

from bt_mission.base.errors import BtMissionError
from bt_mission.commands.convert.attributes import LABELS, is_constant, referred
from bt_mission.commands.convert.elements import Tag, xml_text
from bt_mission.commands.convert.table import (
    FORMAT,
    OUT,
    SUBTREE,
    Names,
    Port,
    Ports,
    leaf_kinds,
    leaf_row,
)
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.message_types import (
    FindShapes,
    InterfaceShapes,
    MessageShape,
    Shape,
    value_type,
)

_COMMON = {
    "service": ("std_srvs/srv/SetBool", "std_srvs/srv/Trigger"),
    "publish": ("std_msgs/msg/String",),
    "wait_for": ("std_msgs/msg/String",),
}
"""Types whose fields are ports of a leaf for any type; more are listed as a mission uses them."""

Used = Mapping[str, Mapping[str, bool]]
"""The attributes of each kind of leaf that a mission uses, and whether it computes one."""


def palette_xml(shapes: FindShapes | None = None, used: Used | None = None) -> str:
    """Return the models of all leaves, as a file without a tree, for Groot 2 to load.

    Args:
        shapes: The fields of ROS types; without it the fields of goals are left out.
        used: Attributes of each kind of leaf that are listed as well, with the type of their port.
    """
    kinds: Used = {kind: {} for kind in leaf_kinds()} | dict(used or {})
    models = Tag("TreeNodesModel", {}, tuple(leaf_models(kinds, shapes)))
    return xml_text(Tag("root", {"BTCPP_format": FORMAT}, (models,)))


def used_attributes(tags: Iterable[Tag]) -> Used:
    """Return the attributes of the leaves in trees, in the order of their first uses."""
    used: dict[str, dict[str, bool]] = {}
    for tag in (inner for candidate in tags for inner in candidate.walk() if leaf_row(inner.name)):
        attributes = used.setdefault(tag.name, {})
        for name, value in tag.attributes.items():
            is_computed = not (is_constant(value) or referred(value))
            attributes[name] = attributes.get(name, False) or is_computed
    return used


def leaf_models(used: Used, shapes: FindShapes | None = None) -> Iterator[Tag]:
    """Yield the models of leaves, by kind.

    Args:
        used: These attributes are listed as well. Computed ones have no type: BehaviorTree.CPP
            refuses an expression at a port with one.
        shapes: The fields of ROS types.
    """
    for kind, attributes in used.items():
        ports = _ports(kind, shapes)
        for name, is_computed in attributes.items():
            if name != "name" and (is_computed and ports.get(name) != LABELS["text"]):
                ports[name] = None
            elif name != "name":
                ports.setdefault(name, None)
        tags = tuple(
            Tag(
                "output_port" if name.startswith(OUT) else "input_port",
                {"name": name, **({"type": label} if label else {})},
            )
            for name, label in ports.items()
        )
        yield Tag("Condition" if kind == "check" else "Action", {"ID": kind}, tags)


def types_read(
    tag: Tag, bodies: Mapping[str, Tag], shapes: FindShapes | None
) -> Iterator[tuple[str, str]]:
    """Yield the variables that an element and those below it read, each with the type of the port.

    Args:
        tag: The element.
        bodies: The trees by their IDs: a SubTree reads what its tree does with the port.
        shapes: The fields of ROS types.
    """
    for inner in tag.walk():
        ports: Mapping[str, str | None]
        if inner.name == SUBTREE:
            ports = dict(types_read(bodies[inner.attributes["ID"]], bodies, shapes))
        elif leaf_row(inner.name):
            ports = _ports(inner.name, shapes)
        else:  # how often, or how long
            ports = dict.fromkeys(inner.attributes, LABELS["integer"])
        for name, value in inner.attributes.items():
            variable, label = referred(value), ports.get(name)
            if variable is not None and label is not None and not name.startswith(OUT):
                yield variable, label


def _ports(kind: str, shapes: FindShapes | None) -> dict[str, str | None]:
    """Return the ports of a leaf that are known without a mission, each with its type.

    The fields of messages are known of actions with a short name, as far as their types are
    installed, and of some common types of services and topics. Those of any type have no type.
    """
    row = leaf_row(kind)
    assert row is not None, "only leaves have models"
    short = ACTION_NAMES.get(kind)
    interfaces: list[InterfaceShapes] = []
    for name in (short.type,) if short else _COMMON.get(kind, ()):
        with suppress(
            BtMissionError
        ):  # a type that is not installed: the attributes in use will do
            interfaces += [] if shapes is None else [shapes(name)]
    ports: dict[str, str | None] = {}
    for column in row.columns:
        if isinstance(column, Port):
            ports[column.name] = None
        elif isinstance(column, Ports):
            for interface in interfaces:
                for path, shape in _nested(
                    interface.keeps if column.prefix == OUT else interface.sends
                ):
                    attribute = column.attribute(path)
                    label = value_type(shape) if short else None
                    if attribute is not None:
                        ports[attribute] = LABELS[label] if label else None
    return ports


def _nested(message: MessageShape, path: Names = ()) -> Iterator[tuple[Names, Shape]]:
    """Yield the fields of a message, each with its path, and behind it the fields in it."""
    for name, shape in message.fields.items():
        yield (*path, name), shape
        if isinstance(shape, MessageShape):
            yield from _nested(shape, (*path, name))
