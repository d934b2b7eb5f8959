"""The nodes that BehaviorTree.CPP brings along, as the nodes that a YAML file would have."""

from __future__ import annotations

from collections.abc import Callable

from bt_mission.btcpp import parts
from bt_mission.btcpp.attributes import FaultReport, number, read_reference
from bt_mission.btcpp.elements import Attribute, Element
from bt_mission.btcpp.leaf_reading import refuse_attribute
from bt_mission.btcpp.parts import Entry, LocatedValue
from bt_mission.btcpp.scripts import ScriptError, assignments, literal
from bt_mission.core.diagnostics import quoted


class BuiltIn:
    """One node that comes with BehaviorTree.CPP.

    `read` reads an element below it, `report` is told of faults.
    """

    def __init__(
        self, element: Element, read: Callable[[Element], LocatedValue], report: FaultReport
    ) -> None:
        self._element = element
        self.read = read
        self.report = report
        self._rest = dict(element.attributes)
        self.at = (element.line, element.column)

    def part(self) -> LocatedValue:
        """Return it as a node."""
        name = self._rest.pop("name", None)
        known, read = BUILT_IN[self._element.tag]
        entries = read(self)
        if name is not None:
            entry = ("name", (name.line, name.column), parts.text(name.value, name))
            entries = [entries[0], entry, *entries[1:]]
        for attribute in self._rest.values():
            refuse_attribute(attribute, self._element.tag, (*known, "name"), self.report)
        return parts.mapping(self.at, entries)

    # ---- children ------------------------------------------------------------------------

    def children(self) -> LocatedValue:
        """Return the nodes below it as a list."""
        if not self._element.children:
            self.report(self.at, f"<{self._element.tag}> has nothing in it")
        nodes = [self.read(child) for child in self._element.children]
        return parts.sequence(self.at, nodes)

    def exactly(self, count: int) -> list[Element]:
        """Return the children, with those that are missing made up."""
        found = self._element.children
        if len(found) != count:
            nodes = "1 node" if count == 1 else f"{count} nodes"
            message = f"expected {nodes} in <{self._element.tag}>, got {len(found)}"
            self.report(self.at, message)
        missing = count - len(found)
        return [*found, *(Element("AlwaysSuccess", *self.at) for _ in range(missing))]

    def child(self) -> LocatedValue:
        """Return the one node below it."""
        return self.read(self.exactly(1)[0])

    # ---- attributes ----------------------------------------------------------------------

    def take(self, name: str, *, needed: bool = True) -> Attribute | None:
        """Return an attribute, after which it counts as read."""
        found = self._rest.pop(name, None)
        if found is None and needed:
            self.report(self.at, f"the attribute '{name}' is missing")
        return found

    def whole(self, name: str, least: int) -> LocatedValue:
        """Return a whole number, or the variable that holds it."""
        attribute = self.take(name)
        if attribute is None:
            return parts.scalar(1, self.at)
        at = (attribute.value_line, attribute.value_column)
        reference = read_reference(attribute)
        if reference is not None:
            return reference
        value = number(attribute.value)
        if not isinstance(value, int) or value < least:
            hint = "for ever has no counterpart; give a number" if value == -1 else None
            message = f"expected a whole number of at least {least}, or a variable '{{name}}'"
            self.report(at, f"{message}, got {quoted(attribute.value)}", hint)
            value = 1
        return parts.scalar(value, at)

    def seconds(self, name: str) -> LocatedValue:
        """Return milliseconds as seconds."""
        milliseconds = self.whole(name, 0)
        value = milliseconds.data
        seconds = f"{value} / 1000" if isinstance(value, str) else value / 1000
        return LocatedValue(seconds, milliseconds.place)

    def count(self, name: str, default: int) -> int:
        """Return how many children, -1 for all."""
        attribute = self.take(name, needed=False)
        many = len(self._element.children)
        value = default if attribute is None else number(attribute.value)
        if value == many and many > 1:
            value = -1
        if value in (1, -1):
            return int(value)
        assert attribute is not None, "the defaults are 1 and -1"
        message = f"expected 1 or -1 (all), got {quoted(attribute.value)}"
        self.report((attribute.value_line, attribute.value_column), message)
        return default

    def code(self, attribute: Attribute) -> LocatedValue:
        """Return a condition."""
        at = (attribute.value_line, attribute.value_column)
        try:
            return parts.scalar(literal(attribute.value.strip()), at)
        except ScriptError as error:
            blanks = len(attribute.value) - len(attribute.value.lstrip())
            where = attribute.at(blanks + error.column - 1)
            self.report(where, error.message, error.hint)
            return parts.scalar(True, at)

    def condition(self, element: Element) -> LocatedValue:
        """Return the condition that a ScriptCondition or a leaf `check` asks."""
        node = self.read(element)
        if list(node.data) != ["check"]:
            message = "expected a ScriptCondition without a name here"
            hint = "only a condition on variables decides between nodes"
            self.report((element.line, element.column), message, hint)
            return parts.scalar(True, self.at)
        assert isinstance(node.place.parts, dict)
        return LocatedValue(node.data["check"], node.place.parts["check"])

    def entry(self, key: str, part: LocatedValue) -> Entry:
        """Return a part of it under a key."""
        return key, self.at, part


Reader = Callable[[BuiltIn], list[Entry]]


def _composite(kind: str, *, memory: bool) -> Reader:
    def read(node: BuiltIn) -> list[Entry]:
        entries = [node.entry(kind, node.children())]
        return entries if memory else [*entries, node.entry("memory", parts.scalar(False, node.at))]

    return read


def _parallel(node: BuiltIn) -> list[Entry]:
    succeed, fail = node.count("success_count", -1), node.count("failure_count", 1)
    entries = [node.entry("parallel", node.children())]
    if succeed == 1:
        entries.append(node.entry("succeed_when", parts.scalar("any", node.at)))
    if fail == -1:
        entries.append(node.entry("fail_when", parts.scalar("impossible", node.at)))
    return entries


def _parallel_all(node: BuiltIn) -> list[Entry]:
    fail = node.count("max_failures", 1)
    entries = [node.entry("parallel", node.children())]
    if fail == -1:
        entries.append(node.entry("succeed_when", parts.scalar("any", node.at)))
        entries.append(node.entry("fail_when", parts.scalar("impossible", node.at)))
    return [*entries, node.entry("rest", parts.scalar("finish", node.at))]


def _repeat(node: BuiltIn) -> list[Entry]:
    count = parts.mapping(node.at, [node.entry("count", node.whole("num_cycles", 1))])
    return [node.entry("repeat", count), node.entry("do", node.child())]


def _retry(node: BuiltIn) -> list[Entry]:
    attempts = parts.mapping(node.at, [node.entry("attempts", node.whole("num_attempts", 1))])
    return [node.entry("retry", attempts), node.entry("do", node.child())]


def _timeout(node: BuiltIn) -> list[Entry]:
    return [node.entry("timeout", node.seconds("msec")), node.entry("do", node.child())]


def _delay(node: BuiltIn) -> list[Entry]:
    wait = parts.mapping(node.at, [node.entry("wait", node.seconds("delay_msec"))])
    return [node.entry("sequence", parts.sequence(node.at, [wait, node.child()]))]


def _sleep(node: BuiltIn) -> list[Entry]:
    seconds = node.seconds("msec")
    node.exactly(0)
    return [node.entry("wait", seconds)]


def _force(status: str) -> Reader:
    return lambda node: [
        node.entry("force", parts.scalar(status, node.at)),
        node.entry("do", node.child()),
    ]


def _check(node: BuiltIn) -> list[Entry]:
    code = node.take("code")
    part = parts.scalar(True, node.at) if code is None else node.code(code)
    node.exactly(0)
    return [node.entry("check", part)]


def _always(*, holds: bool) -> Reader:
    def read(node: BuiltIn) -> list[Entry]:
        node.exactly(0)
        return [node.entry("check", parts.scalar(holds, node.at))]

    return read


def _script(node: BuiltIn) -> list[Entry]:
    code = node.take("code")
    node.exactly(0)
    if code is None:
        return [node.entry("set", parts.mapping(node.at, ()))]
    at = (code.value_line, code.value_column)
    try:
        found = assignments(code.value)
    except ScriptError as error:
        node.report(code.at(error.column - 1), error.message, error.hint)
        found = []
    else:
        if not found:
            node.report(at, "expected 'name := value', got nothing")
    values = [(name, code.at(column - 1), parts.scalar(value, at)) for name, column, value in found]
    return [node.entry("set", parts.mapping(at, values))]


def _precondition(node: BuiltIn) -> list[Entry]:
    code, otherwise = node.take("if"), node.take("else", needed=False)
    question = parts.scalar(True, node.at) if code is None else node.code(code)
    child = node.child()
    value = "FAILURE" if otherwise is None else otherwise.value
    if value == "SUCCESS":
        return [node.entry("when", question), node.entry("do", child)]
    if otherwise is not None and value != "FAILURE":
        message = f"expected SUCCESS or FAILURE, got {quoted(value)}"
        node.report((otherwise.value_line, otherwise.value_column), message)
    check = parts.mapping(node.at, [node.entry("check", question)])
    return [node.entry("sequence", parts.sequence(node.at, [check, child]))]


def _if_then_else(node: BuiltIn) -> list[Entry]:
    first, second, third = node.exactly(3)[:3]
    entries = [node.entry("when", node.condition(first)), node.entry("do", node.read(second))]
    if third.tag == "AlwaysSuccess" and not third.attributes and not third.children:
        return entries
    return [*entries, node.entry("else", node.read(third))]


def _while_do_else(node: BuiltIn) -> list[Entry]:
    first, second = node.exactly(2)[:2]
    return [node.entry("guard", node.condition(first)), node.entry("do", node.read(second))]


BUILT_IN: dict[str, tuple[tuple[str, ...], Reader]] = {
    "Sequence": ((), _composite("sequence", memory=True)),
    "ReactiveSequence": ((), _composite("sequence", memory=False)),
    "Fallback": ((), _composite("fallback", memory=True)),
    "ReactiveFallback": ((), _composite("fallback", memory=False)),
    "Parallel": (("success_count", "failure_count"), _parallel),
    "ParallelAll": (("max_failures",), _parallel_all),
    "Repeat": (("num_cycles",), _repeat),
    "RetryUntilSuccessful": (("num_attempts",), _retry),
    "Timeout": (("msec",), _timeout),
    "Delay": (("delay_msec",), _delay),
    "Inverter": ((), lambda node: [node.entry("invert", node.child())]),
    "ForceSuccess": ((), _force("success")),
    "ForceFailure": ((), _force("failure")),
    "AlwaysSuccess": ((), _always(holds=True)),
    "AlwaysFailure": ((), _always(holds=False)),
    "Precondition": (("if", "else"), _precondition),
    "IfThenElse": ((), _if_then_else),
    "WhileDoElse": ((), _while_do_else),
    "ScriptCondition": (("code",), _check),
    "Script": (("code",), _script),
    "Sleep": (("msec",), _sleep),
}
"""The nodes of BehaviorTree.CPP that have a counterpart: their attributes, and what reads them."""
