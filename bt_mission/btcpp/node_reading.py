"""From the elements of a tree to the nodes that a YAML file would have."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from bt_mission.btcpp import parts
from bt_mission.btcpp.built_in import BUILT_IN, BuiltIn
from bt_mission.btcpp.elements import Element, XmlSource
from bt_mission.btcpp.leaf_reading import read_leaf
from bt_mission.btcpp.leaves import LEAVES
from bt_mission.btcpp.parts import At, LocatedValue
from bt_mission.btcpp.ports import TreePorts, read_use
from bt_mission.core.diagnostics import MOST_FAULTS, Diagnostic, did_you_mean, quoted

EXPLICIT = ("Action", "Condition", "Control", "Decorator")
"""Elements that name their node by the attribute ID."""

SUBTREE = "SubTree"
_HINTS = {
    "SequenceWithMemory": "a 'Sequence' begins anew after a failure; there is no other",
    "KeepRunningUntilFailure": "write 'Repeat' with a number of cycles",
    "SetBlackboard": "write 'Script', such as code=\"x := 1\"",
    "RunOnce": "write 'Precondition' on a variable that a 'Script' sets",
    "SubTreePlus": "write 'SubTree'",
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
            self.faults.append(self.source.fault(at, message, hint))

    def node(self, element: Element) -> LocatedValue:
        """Return an element and all below it as a node."""
        at = (element.line, element.column)
        named = self._resolved(element)
        if named is None:
            return parts.mapping(at, ())
        if named.text:
            self.report(named.text_at, f"a loose text in <{element.tag}>: {quoted(named.text)}")
        if named.tag in LEAVES:
            return read_leaf(LEAVES[named.tag], named, self.report)
        if named.tag == SUBTREE:
            return read_use(named, self.trees, self.report)
        if named.tag in BUILT_IN:
            return BuiltIn(named, self.node, self.report).part()
        known = [*BUILT_IN, SUBTREE, *LEAVES]
        hint = _HINTS.get(named.tag) or did_you_mean(named.tag, known)
        message = f"the node {quoted(named.tag)} has no counterpart"
        self.report(
            (named.line, named.column),
            message,
            hint or "docs/how-to/groot.md lists those that have",
        )
        for child in named.children:
            self.node(child)
        return parts.mapping(at, ())

    def _resolved(self, element: Element) -> Element | None:
        """Return `<Action ID="turn"/>` as `<turn/>`, and any other element as it is."""
        if element.tag not in EXPLICIT:
            return element
        rest = dict(element.attributes)
        name = rest.pop("ID", None)
        if name is None:
            message = f"<{element.tag}> does not say which: the attribute 'ID' is missing"
            self.report((element.line, element.column), message)
            return None
        at = (name.value_line, name.value_column)
        return Element(name.value, *at, rest, element.children, element.text, element.text_at)
