"""What nodes are made of, from an element and to one: children, numbers, durations, conditions."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Protocol

from bt_mission.btcpp.attributes import (
    VARIABLE,
    VARIABLE_NAME,
    FaultReport,
    LocatedValue,
    entry,
    located,
    mapping,
    number,
    read_reference,
    read_value,
    read_variable,
    refuse_attribute,
)
from bt_mission.btcpp.elements import Attribute, Element, Tag
from bt_mission.btcpp.leaves import Path
from bt_mission.btcpp.scripts import ScriptError, literal, to_script
from bt_mission.core.diagnostics import quoted
from bt_mission.language.nodes.fields import SECONDS, is_quantity

_THOUSANDTH = re.compile(r"\$([A-Za-z_][A-Za-z0-9_]*) / 1000")
_LARGEST_MSEC = 2**31 - 1

SKIP = "_skipIf"
_ON_SKIP = {
    **dict.fromkeys(("Sequence", "AsyncSequence", "ReactiveSequence"), "sequence"),
    **dict.fromkeys(("Fallback", "AsyncFallback", "ReactiveFallback"), "fallback"),
}
"""The composites that go on with the next child where one is skipped. Where all are, they are
skipped themselves, which has no counterpart."""


class NodeElement:
    """An element of BehaviorTree.CPP that is read as a node.

    `read` reads an element below it, `report` is told of faults.
    """

    def __init__(
        self, element: Element, read: Callable[[Element], LocatedValue], report: FaultReport
    ) -> None:
        self.tag = element.tag
        self.at = element.at
        self.read = read
        self.report = report
        self._children = element.children
        self._rest = dict(element.attributes)

    def node(self, data: Mapping[str, Any], known: tuple[str, ...]) -> LocatedValue:
        """Return it as a node of this data; what is left of its attributes is refused."""
        entries = [(key, self.at, located(value, self.at)) for key, value in data.items()]
        name = self.take("name", needed=False)
        if name is not None:
            entries.insert(1, entry(name))
        for attribute in self._rest.values():
            refuse_attribute(attribute, self.tag, (*known, "name"), self.report)
        return mapping(self.at, entries)

    def children(self) -> list[LocatedValue]:
        """Return the nodes below it."""
        if not self._children:
            self.report(self.at, f"<{self.tag}> has nothing in it")
        has_other = any(SKIP not in child.attributes for child in self._children)
        skips = _ON_SKIP.get(self.tag) if has_other else None
        return [
            self._skipped(child, skips) if skips and SKIP in child.attributes else self.read(child)
            for child in self._children
        ]

    def _skipped(self, child: Element, skips: str) -> LocatedValue:
        """Return a child that is left out where the condition of its `_skipIf` holds."""
        rest = dict(child.attributes)
        attribute = rest.pop(SKIP)
        inner = self.read(replace(child, attributes=rest))
        code = self._literal(attribute)
        asked = LocatedValue(negated(code.data), code.place)
        if skips == "sequence":
            return located({"when": asked, "do": inner}, child.at)
        return located({"sequence": [located({"check": asked}, child.at), inner]}, child.at)

    @property
    def count_children(self) -> int:
        """How many children it has."""
        return len(self._children)

    def exactly(self, count: int) -> list[Element]:
        """Return so many children, with those that are missing made up."""
        if len(self._children) != count:
            nodes = "1 node" if count == 1 else f"{count} nodes"
            self.report(self.at, f"expected {nodes} in <{self.tag}>, got {len(self._children)}")
        return self.first(count)

    def first(self, count: int) -> list[Element]:
        """Return the first children, with those that are missing made up, and no report of it."""
        missing = count - len(self._children)
        made_up = (Element("AlwaysSuccess", self.at) for _ in range(missing))
        return [*self._children, *made_up][:count]

    def child(self) -> LocatedValue:
        """Return the one node below it."""
        return self.read(self.exactly(1)[0])

    def take(self, name: str, *, needed: bool = True) -> Attribute | None:
        """Return an attribute, after which it counts as read."""
        found = self._rest.pop(name, None)
        if found is None and needed:
            self.report(self.at, f"the attribute '{name}' is missing")
        return found

    def has(self, name: str) -> bool:
        """Return whether an attribute is there that was not read yet."""
        return name in self._rest

    def value(self, name: str, default: Any) -> LocatedValue:
        """Return a literal, or the variable that holds it."""
        found = self.take(name, needed=False)
        return located(default, self.at) if found is None else read_value(found, self.report)

    def reference(self, name: str, what: str) -> LocatedValue:
        """Return the variable of an attribute that takes nothing else."""
        found = self.take(name)
        reference = None if found is None else read_reference(found)
        if found is not None and reference is None:
            message = f"expected a variable such as '{{{name}}}' with {what}"
            self.report(found.value_at, f"{message}, got {quoted(found.value)}")
        return reference or located([], self.at)

    def variable(self, name: str) -> LocatedValue:
        """Return the name of the variable that an attribute writes to."""
        found = self.take(name)
        return located("_", self.at) if found is None else read_variable(found, self.report)

    def times(self, name: str, least: int = 1) -> LocatedValue:
        """Return a whole number, or the variable that holds it."""
        attribute = self.take(name)
        if attribute is None:
            return located(1, self.at)
        reference = read_reference(attribute)
        if reference is not None:
            return reference
        value = number(attribute.value)
        if not isinstance(value, int) or value < least:
            hint = "for ever has no counterpart; give a number" if value == -1 else None
            message = f"expected an integer of at least {least}, or a variable '{{name}}'"
            self.report(attribute.value_at, f"{message}, got {quoted(attribute.value)}", hint)
            value = 1
        return located(value, attribute.value_at)

    def seconds(self, name: str) -> LocatedValue:
        """Return milliseconds as seconds."""
        milliseconds = self.times(name, least=0)
        value = milliseconds.data
        seconds = f"{value} / 1000" if isinstance(value, str) else value / 1000
        return LocatedValue(seconds, milliseconds.place)

    def count(self, name: str, default: int) -> int:
        """Return how many children, -1 for all."""
        attribute = self.take(name, needed=False)
        many = len(self._children)
        value = default if attribute is None else number(attribute.value)
        if value == many and many > 1:
            value = -1
        if value in (1, -1):
            return int(value)
        assert attribute is not None, "the defaults are 1 and -1"
        message = f"expected 1 or -1 (all), got {quoted(attribute.value)}"
        self.report(attribute.value_at, message)
        return default

    def code(self, name: str) -> LocatedValue:
        """Return the condition that an attribute holds as a script."""
        attribute = self.take(name)
        return located(True, self.at) if attribute is None else self._literal(attribute)

    def _literal(self, attribute: Attribute) -> LocatedValue:
        """Return what an attribute holds as a script."""
        try:
            return located(literal(attribute.value.strip()), attribute.value_at)
        except ScriptError as error:
            blanks = len(attribute.value) - len(attribute.value.lstrip())
            where = attribute.within(blanks + error.column - 1)
            self.report(where, error.message, error.hint)
            return located(True, attribute.value_at)

    def condition(self, element: Element) -> LocatedValue:
        """Return the condition that a ScriptCondition or a leaf `check` asks."""
        node = self.read(element)
        if list(node.data) != ["check"]:
            message = "expected a ScriptCondition without a name here"
            hint = "only a condition on variables decides between nodes"
            self.report(element.at, message, hint)
            return located(True, self.at)
        assert isinstance(node.place.parts, dict)
        return LocatedValue(node.data["check"], node.place.parts["check"])


class ElementWriter(Protocol):
    """Writes nodes as elements."""

    def node(self, data: dict[str, Any], path: Path) -> Tag:
        """Return a node and all below it."""

    def leaf(self, kind: str, data: dict[str, Any], path: Path) -> Tag:
        """Return a leaf of ours."""

    def refuse(self, path: Path, what: str, instead: str, *, key: bool = False) -> None:
        """Note what XML cannot say."""


@dataclass(frozen=True)
class NodeData:
    """A node of a mission file that is written as an element."""

    data: dict[str, Any]
    path: Path
    writer: ElementWriter

    def refuse(self, what: str, instead: str, *keys: str, key: bool = False) -> None:
        """Note what XML cannot say of the part below these keys, or of the last of them."""
        self.writer.refuse((*self.path, *keys), what, instead, key=key)

    def children(self, key: str) -> tuple[Tag, ...]:
        """Return the children of a composite."""
        nodes = enumerate(self.data[key])
        return tuple(self.writer.node(one, (*self.path, key, i)) for i, one in nodes)

    def child(self, key: str = "do") -> Tag:
        """Return the one child of a decorator."""
        return self.writer.node(self.data[key], (*self.path, key))

    def leaf(self, kind: str) -> Tag:
        """Return the node as a leaf of ours."""
        return self.writer.leaf(kind, self.data, self.path)

    def times(self, kind: str, key: str) -> str:
        """Return how often, as a number or a variable."""
        value = self.data[kind][key]
        found = VARIABLE_NAME.fullmatch(value) if isinstance(value, str) else None
        if found:
            return VARIABLE.write(found[1])
        if isinstance(value, str):
            hint = "'set' a variable to it first, and give its name"
            self.refuse("an expression for how often", hint, kind, key)
        return str(value)

    def milliseconds(self, key: str) -> str | None:
        """Return seconds as milliseconds, or None where they are none."""
        value = self.data[key]
        found = _THOUSANDTH.fullmatch(value) if isinstance(value, str) else None
        if found:
            return VARIABLE.write(found[1])
        if isinstance(value, str):
            if not is_quantity(value):
                return None
            value = SECONDS.parse(value)
            assert isinstance(value, int | float)
        if value * 1000 > _LARGEST_MSEC:
            return None
        whole = round(value * 1000)
        return str(whole) if whole / 1000 == value else None

    def code(self, key: str) -> str | None:
        """Return a condition as a script, or None where it has none that comes back as the same."""
        value = self.data[key]
        if isinstance(value, bool):
            return "true" if value else "false"
        code = to_script(value)
        return code if code is not None and literal(code) == value else None

    def condition(self, key: str) -> Tag:
        """Return a condition as a node that asks it."""
        code = self.code(key)
        if code is not None:
            return Tag("ScriptCondition", {"code": code})
        return self.writer.leaf("check", {"check": self.data[key]}, self.path)


def negated(condition: Any) -> bool | str:
    """Return the opposite of a condition."""
    return not condition if isinstance(condition, bool) else f"not ({condition})"
