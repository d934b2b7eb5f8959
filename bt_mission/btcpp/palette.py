"""The `TreeNodesModel` of our leaves, from which Groot 2 learns their ports."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from bt_mission.btcpp.attributes import referred
from bt_mission.btcpp.document import FORMAT
from bt_mission.btcpp.elements import Tag, xml_text
from bt_mission.btcpp.leaves import LEAVES, OUT, LeafElement, Names
from bt_mission.btcpp.ports import LABELS, SUBTREE
from bt_mission.core.errors import BtMissionError
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.checks.types import FindShapes
from bt_mission.language.message_types import (
    ActionShapes,
    MessageShape,
    ServiceShapes,
    Shape,
    value_type,
)

_COMMON = {
    "service": ("std_srvs/srv/SetBool", "std_srvs/srv/Trigger"),
    "publish": ("std_msgs/msg/String",),
    "wait_for": ("std_msgs/msg/String",),
}
"""Types whose fields are ports of a leaf for any type; more are listed as a mission uses them."""


def palette_xml(
    shapes: FindShapes | None = None, used: Mapping[str, Iterable[str]] | None = None
) -> str:
    """Return the models of all leaves, as a file without a tree, for Groot 2 to load.

    Args:
        shapes: Tells what ROS types hold; without it the fields of goals are left out.
        used: Attributes of each kind of leaf that are listed as well.
    """
    kinds: dict[str, Iterable[str]] = {**dict.fromkeys(LEAVES, ()), **(used or {})}
    models = Tag("TreeNodesModel", {}, tuple(leaf_models(kinds, shapes)))
    return xml_text(Tag("root", {"BTCPP_format": FORMAT}, (models,)))


def leaf_models(
    used: Mapping[str, Mapping[str, bool] | Iterable[str]], shapes: FindShapes | None = None
) -> Iterator[Tag]:
    """Yield the models of leaves, by kind.

    Args:
        used: The attributes that a mission uses are listed as well. Those that it computes (true)
            have no type: BehaviorTree.CPP refuses an expression at a port with one.
        shapes: Tells what ROS types hold.
    """
    for kind, attributes in used.items():
        ports = _ports(LEAVES[kind], shapes)
        ports |= {name: None for name in attributes if name != "name" and name not in ports}
        if isinstance(attributes, Mapping):
            ports |= {
                name: None
                for name, is_computed in attributes.items()
                if is_computed and ports.get(name) not in (None, LABELS["text"])
            }
        tags = tuple(_port(name, label) for name, label in ports.items())
        yield Tag("Condition" if kind == "check" else "Action", {"ID": kind}, tags)


def _ports(leaf: LeafElement, shapes: FindShapes | None) -> dict[str, str | None]:
    """Return the ports of a leaf that are known without a mission, each with its type."""
    fields, outputs = field_ports(leaf, shapes)
    return {
        **dict.fromkeys([leaf.whole] if leaf.whole else leaf.settings),
        **{name: _label(leaf, shape) for name, shape in fields.items()},
        **dict.fromkeys(leaf.modifiers),
        **{name: _label(leaf, shape) for name, shape in outputs.items()},
    }


def types_read(
    tag: Tag, bodies: Mapping[str, Tag], shapes: FindShapes | None
) -> Iterator[tuple[str, str]]:
    """Yield the variables that an element and those below it read, each with the type of the port.

    Args:
        tag: The element.
        bodies: The trees by their IDs: a SubTree reads what its tree does with the port.
        shapes: Tells what ROS types hold.
    """
    if tag.name == SUBTREE:
        inner = dict(types_read(bodies[tag.attributes["ID"]], bodies, shapes))
        ports: Mapping[str, str | None] = inner
    elif tag.name in LEAVES:
        ports = _ports(LEAVES[tag.name], shapes)
    else:  # how often, or how long
        ports = dict.fromkeys(tag.attributes, LABELS["integer"])
    for name, value in tag.attributes.items():
        variable, label = referred(value), ports.get(name)
        if variable is not None and label is not None and not name.startswith(OUT):
            yield variable, label
    for child in tag.children:
        yield from types_read(child, bodies, shapes)


def field_ports(
    leaf: LeafElement, shapes: FindShapes | None
) -> tuple[dict[str, Shape], dict[str, Shape]]:
    """Return the attributes of a leaf for fields of what it sends, and of what it gives.

    Those are known of actions with a short name, as far as their types are installed, and of some
    common types of services and topics. Fields within fields have attributes of their own.
    """
    short = (ACTION_NAMES[leaf.kind].type,) if leaf.kind in ACTION_NAMES else ()
    sent: dict[str, Shape] = {}
    given: dict[str, Shape] = {}
    for name in short or _COMMON.get(leaf.kind, ()):
        taken, returned = _messages(leaf, name, shapes)
        for path, shape in _nested(taken):
            attribute = leaf.field_attribute(path)
            if attribute is not None:
                sent[attribute] = shape
        if leaf.gives:
            given |= {leaf.output_attribute(".".join(path)): one for path, one in _nested(returned)}
    return sent, given


def _messages(
    leaf: LeafElement, name: str, shapes: FindShapes | None
) -> tuple[MessageShape | None, MessageShape | None]:
    """Return what a leaf sends and what it gives, for a type."""
    try:
        found = shapes(name) if shapes is not None else None
    except BtMissionError:  # a type that is not installed: the attributes in use will do
        return None, None
    match found:
        case ActionShapes():
            return found.goal, found.result
        case ServiceShapes():
            return found.request, found.response
        case MessageShape() if leaf.fields:
            return found, None
        case MessageShape():
            return None, found
    return None, None


def _nested(message: MessageShape | None, path: Names = ()) -> Iterator[tuple[Names, Shape]]:
    """Yield the fields of a message, each with its path, and behind it the fields in it."""
    for name, shape in message.fields.items() if message else ():
        yield (*path, name), shape
        if isinstance(shape, MessageShape):
            yield from _nested(shape, (*path, name))


def _port(name: str, label: str | None) -> Tag:
    direction = "output_port" if name.startswith(OUT) else "input_port"
    return Tag(direction, {"name": name, **({"type": label} if label else {})})


def _label(leaf: LeafElement, shape: Shape) -> str | None:
    """Return what Groot 2 shows as the type; a leaf for any type has none."""
    kind = value_type(shape) if leaf.kind in ACTION_NAMES else None
    return LABELS[kind] if kind else None
