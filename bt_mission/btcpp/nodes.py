"""The nodes of a tree: read from the elements of an XML file, and written as such."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_mission.btcpp.attributes import LocatedValue, is_constant, located, referred
from bt_mission.btcpp.built_in import BUILT_IN, KINDS
from bt_mission.btcpp.elements import Element, Tag, XmlSource
from bt_mission.btcpp.leaves import LEAVES, Path, read_leaf, write_leaf
from bt_mission.btcpp.node_parts import NodeData, NodeElement
from bt_mission.btcpp.ports import SUBTREE, TreePorts, read_use, write_use
from bt_mission.core.diagnostics import MOST_FAULTS, Diagnostic, did_you_mean, fault_at, quoted
from bt_mission.core.yaml.composer import At
from bt_mission.core.yaml.document import Document
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.goal_limits import DEFAULTS, GoalLimitsTable
from bt_mission.language.node_reader import NodeReader, Signature

EXPLICIT = ("Action", "Condition", "Control", "Decorator")
"""Elements that name their node by the attribute ID."""

STAND_IN = (
    "an <action> leaf, for a node with an action server, or a <python> leaf can stand in for your "
    "own node (docs/how-to/groot.md)"
)

_HINTS = {
    "SequenceWithMemory": "a 'Sequence' begins anew after a failure; there is no other",
    "RunOnce": "write 'Precondition' on a variable that a 'Script' sets",
    "SubTreePlus": "write 'SubTree'",
    **{f"Switch{count}": "write an IfThenElse for each case" for count in range(2, 7)},
    **dict.fromkeys(
        ("LoopBool", "LoopDouble", "LoopInt", "LoopString"), "write 'for_each', which only YAML has"
    ),
    **dict.fromkeys(
        ("SkipUnlessUpdated", "WaitValueUpdate", "WasEntryUpdated"),
        "no variable of a mission knows when it was written; use a leaf 'wait_for' on a topic",
    ),
    "UnsetBlackboard": "set the variable to a value that stands for none",
}


@dataclass
class XmlNodeReader:
    """Reads elements as nodes, and collects the faults of all."""

    source: XmlSource
    trees: Mapping[str, TreePorts] = field(default_factory=dict)
    faults: list[Diagnostic] = field(default_factory=list)

    def report(self, at: At, message: str, hint: str | None = None) -> None:
        """Note a fault."""
        if len(self.faults) < MOST_FAULTS:
            source = self.source
            self.faults.append(fault_at(at, source.file, source.lines, message, hint))

    def node(self, element: Element) -> LocatedValue:
        """Return an element and all below it as a node."""
        named = self._resolved(element)
        if named is None:
            return located({}, element.at)
        if named.text:
            self.report(named.text_at, f"a loose text in <{element.tag}>: {quoted(named.text)}")
        if named.tag in LEAVES:
            return read_leaf(LEAVES[named.tag], named, self.report)
        if named.tag == SUBTREE:
            return read_use(named, self.trees, self.report)
        if named.tag in BUILT_IN:
            known, read = BUILT_IN[named.tag]
            node = NodeElement(named, self.node, self.report)
            return node.node(read(node), known)
        hint = _HINTS.get(named.tag)
        if hint is None:
            near = did_you_mean(named.tag, [*BUILT_IN, SUBTREE, *LEAVES])
            hint = f"{near} {STAND_IN}" if near else STAND_IN
        self.report(named.at, f"the node {quoted(named.tag)} has no counterpart", hint)
        for child in named.children:
            self.node(child)
        return located({}, element.at)

    def _resolved(self, element: Element) -> Element | None:
        """Return `<Action ID="turn"/>` as `<turn/>`, and any other element as it is."""
        if element.tag not in EXPLICIT:
            return element
        rest = dict(element.attributes)
        name = rest.pop("ID", None)
        if name is None:
            message = f"<{element.tag}> does not say which: the attribute 'ID' is missing"
            self.report(element.at, message)
            return None
        return Element(
            name.value, name.value_at, rest, element.children, element.text, element.text_at
        )


@dataclass
class NodeWriter:
    """Writes nodes of one document as elements, and collects what cannot be said.

    `limits` are the mission's; `used` gathers the attributes of each kind of leaf:
    is there one that is computed?
    """

    document: Document
    signatures: Mapping[str, Signature]
    limits: GoalLimitsTable
    used: dict[str, dict[str, bool]]
    faults: list[Diagnostic] = field(default_factory=list)
    _names: set[str] = field(default_factory=set)
    """Of the uses of trees so far."""

    def refuse(self, path: Path, what: str, instead: str, *, key: bool = False) -> None:
        """Note what XML cannot say."""
        if len(self.faults) < MOST_FAULTS:
            message = f"{what}: XML has no counterpart"
            self.faults.append(self.document.fault(path, message, instead, key=key))

    def node(self, data: dict[str, Any], path: Path) -> Tag:
        """Return a node and all below it as an element."""
        kind = NodeReader(self.document).kind(data, path)
        assert kind is not None, "the mission was read before"
        if kind in KINDS:
            tag = KINDS[kind].write(NodeData(data, path, self))
        elif kind == "tree":
            if (name := data.get("name")) in self._names:
                hint = "give one of them another name: BehaviorTree.CPP refuses two of one name"
                self.refuse(
                    (*path, "name"), f"two uses of trees with the name {quoted(name)}", hint
                )
            elif name:
                self._names.add(name)
            tag = write_use(data, path, self.signatures, self.refuse)
        elif kind in LEAVES:
            return self.leaf(kind, data, path)
        else:
            hint = "write its nodes one by one, or keep the mission in YAML"
            self.refuse((*path, kind), f"'{kind}'", hint, key=True)
            for inner_path, inner in _below(kind, data, path):
                self.node(inner, inner_path)
            return Tag("AlwaysSuccess")
        named = {"name": data["name"]} if data.get("name") else {}
        return Tag(tag.name, {**named, **tag.attributes}, tag.children)

    def leaf(self, kind: str, data: dict[str, Any], path: Path) -> Tag:
        """Return a leaf of ours."""
        if kind in ACTION_NAMES or kind == "action":
            action = data["action"]["name"] if kind == "action" else ACTION_NAMES[kind].action
            said = self.limits.of(action).items()
            data = {**{name: one for name, one in said if one != DEFAULTS.get(name)}, **data}
        attributes = write_leaf(LEAVES[kind], data, path, self.refuse)
        used = self.used.setdefault(kind, {})
        for name, value in attributes.items():
            used[name] = used.get(name, False) or not (is_constant(value) or referred(value))
        return Tag(kind, attributes)


def _below(kind: str, data: dict[str, Any], path: Path) -> list[tuple[Path, dict[str, Any]]]:
    """Return the nodes within one that cannot be said."""
    if isinstance(data[kind], list):
        return [((*path, kind, i), one) for i, one in enumerate(data[kind])]
    return [((*path, key), data[key]) for key in ("do", "then") if key in data]
