"""The `TreeNodesModel` of our leaves, from which Groot 2 learns their ports."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from bt_mission.btcpp.document import FORMAT
from bt_mission.btcpp.elements import Tag, xml_text
from bt_mission.btcpp.leaves import LEAVES, OUT, LeafElement
from bt_mission.btcpp.ports import LABELS
from bt_mission.core.errors import BtMissionError
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.checks.types import FindShapes
from bt_mission.language.message_types import ActionShapes, Shape, value_type


def palette_xml(shapes: FindShapes | None = None) -> str:
    """Return the models of all leaves, as a file without a tree, for Groot 2 to load."""
    models = Tag("TreeNodesModel", {}, tuple(leaf_models(dict.fromkeys(LEAVES, ()), shapes)))
    return xml_text(Tag("root", {"BTCPP_format": FORMAT}, (models,)))


def leaf_models(
    used: Mapping[str, Iterable[str]], shapes: FindShapes | None = None
) -> Iterator[Tag]:
    """Yield the models of leaves, by kind; those attributes are listed as well that are `used`."""
    for kind, attributes in used.items():
        ports = _ports(LEAVES[kind], shapes)
        ports |= {name: None for name in attributes if name != "name" and name not in ports}
        tags = tuple(_port(name, label) for name, label in ports.items())
        yield Tag("Condition" if kind == "check" else "Action", {"ID": kind}, tags)


def _ports(leaf: LeafElement, shapes: FindShapes | None) -> dict[str, str | None]:
    """Return the ports of a leaf that are known without a mission, each with its type."""
    found = action_shapes(leaf, shapes)
    goal, result = (found.goal.fields, found.result.fields) if found else ({}, {})
    fields = {leaf.field_attribute((name,)): _label(shape) for name, shape in goal.items()}
    return {
        **dict.fromkeys([leaf.whole] if leaf.whole else leaf.settings),
        **{name: label for name, label in fields.items() if name is not None},
        **dict.fromkeys(leaf.modifiers),
        **{leaf.output_attribute(name): _label(shape) for name, shape in result.items()},
    }


def action_shapes(leaf: LeafElement, shapes: FindShapes | None) -> ActionShapes | None:
    """Return what the type of an action with a short name holds, as far as that is known."""
    if shapes is None or leaf.kind not in ACTION_NAMES:
        return None
    try:
        found = shapes(ACTION_NAMES[leaf.kind].type)
    except BtMissionError:  # a type that is not installed: the attributes in use will do
        return None
    return found if isinstance(found, ActionShapes) else None


def _port(name: str, label: str | None) -> Tag:
    direction = "output_port" if name.startswith(OUT) else "input_port"
    return Tag(direction, {"name": name, **({"type": label} if label else {})})


def _label(shape: Shape) -> str | None:
    kind = value_type(shape)
    return LABELS[kind] if kind else None
