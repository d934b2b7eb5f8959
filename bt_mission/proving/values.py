"""The values of messages and draws that the conditions of a mission can tell apart.

A number that is compared with constants has the values on both sides of each and the constant
itself; so has one that is passed to a variable that is compared. A value that nobody compares has
one value. Where a condition reads arithmetic that is
not followed, the values are samples, :attr:`ValueCases.sampled` names them, and the exploration is
not exhaustive.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice, product
from typing import Any, TypeAlias

from bt_mission.behaviours.evaluator import MessageFields
from bt_mission.behaviours.runtime import read_field
from bt_mission.language.expressions.expression import Expression, Template, Text
from bt_mission.language.expressions.syntax import (
    Comparison,
    Constant,
    Name,
    Negation,
    SyntaxNode,
)
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.base import NodeModel, OutputsNode
from bt_mission.language.nodes.interfaces import InterfaceNode
from bt_mission.language.nodes.leaves import SetNode
from bt_mission.language.nodes.subtree import TreeNode
from bt_mission.language.requirements.formula import Requirement
from bt_mission.language.requirements.syntax import SignalValue


class Known(dict[Any, Any]):
    """Cached results; not a part of a state."""


MOST_COMBINATIONS = 64
"""Combinations of values of one message that are tried."""
OTHER_TEXT = "other"


Flow: TypeAlias = tuple[str, str, bool]
"""A name, the variable that gets a value with it, and whether that is the value as it is."""


class ValueCases:
    """The constants with which a mission compares each name.

    Args:
        mission: Whose conditions count, those of its named trees included.
        requirements: Their conditions on variables count, too.
    """

    def __init__(self, mission: Mission, requirements: Iterable[Requirement] = ()) -> None:
        self._constants: dict[str, set[bool | int | float | str]] = {}
        self._compared: set[str] = set()
        self._asked: set[str] = set()
        self._messages, self._names, self._met = Known(), Known(), Known()
        self.sampled: set[str] = set()
        """Names with values that not all are tried, and conditions that no tried message meets."""
        nodes = [node for tree in mission.all_trees for node in tree.body.walk()]
        for node in nodes:
            for value in _values_of(node):
                for expression in _expressions(value):
                    self._note(expression.root, mission.inputs)
        for requirement in requirements:
            self._note(requirement.root, mission.inputs)
        read = {entry.variable for tree in mission.all_trees for entry in tree.follow}
        for node in nodes:
            if isinstance(node, OutputsNode) and not isinstance(node, TreeNode):
                read.update(node.outputs.values())
        self._trace_back([flow for node in nodes for flow in _flows_of(node)], read)

    def _trace_back(self, flows: Sequence[Flow], read: set[str]) -> None:
        """Have names with a value that is passed to others distinguish what those distinguish.

        Args:
            read: Variables with values of messages.
        """
        while more := {target for source, target, _ in flows if source in read} - read:
            read |= more
        is_more = True
        while is_more:
            is_more = False
            for source, target, is_whole in flows:
                if source not in read or target not in self._compared | self._asked:
                    continue
                before = self._kept_of(source)
                if target in self._asked:
                    self._asked.add(source)
                if target in self._compared:
                    self._compared.add(source)
                    constants = self._constants.setdefault(source, set())
                    constants |= self._constants.get(target, set())
                    self.sampled |= set() if is_whole else {source}
                is_more |= self._kept_of(source) != before

    def _kept_of(self, name: str) -> tuple[int, ...]:
        return name in self._asked, name in self._compared, len(self._constants.get(name, ()))

    def _note(self, root: SyntaxNode, inputs: Mapping[str, Any]) -> None:
        if _is_name(root):
            self._asked.add(_name_of(root))
        for part in _parts(root):
            if not isinstance(part, Comparison):
                self._asked |= {_name_of(entry) for entry in part.parts if _is_name(entry)}
                continue
            parts = list(_parts(part))
            names = {_name_of(entry) for entry in parts if _is_name(entry)}
            constants = {entry.value for entry in parts if isinstance(entry, Constant)}
            constants |= {-value for entry in parts if (value := _negated(entry)) is not None}
            constants |= {inputs[name] for name in names if name in inputs}
            is_plain = all(
                _is_name(side) or isinstance(side, Constant) or _negated(side) is not None
                for side in part.parts
            )
            if not is_plain or len(names - set(inputs)) > 1:
                self.sampled |= names - set(inputs)
            plain = {entry for entry in constants if isinstance(entry, bool | int | float | str)}
            self._compared |= names
            for name in names:
                self._constants.setdefault(name, set()).update(plain)

    def of(self, name: str, default: Any) -> tuple[Any, ...]:
        """Return the values of a name that conditions can tell apart, the default first.

        Args:
            default: A value of the type that it has.
        """
        constants = self._constants.get(name, set())
        match default:
            case bool():
                return (True, False) if name in self._compared | self._asked else (default,)
            case str():
                texts = sorted(entry for entry in constants if isinstance(entry, str))
                return (*texts, OTHER_TEXT) if name in self._compared else (default,)
            case int() | float() if name in self._compared:
                numbers = [entry for entry in constants if isinstance(entry, int | float)]
                kind = type(default)
                collected = {kind(default): None}
                for number in sorted(numbers) or [0]:
                    collected |= dict.fromkeys(map(kind, (number, number - 1, number + 1)))
                return tuple(collected)
        return (default,)

    def combinations(self, cases: Mapping[str, Sequence[Any]]) -> Iterator[dict[str, Any]]:
        """Yield messages as fields, each with one of its values; a bounded number of them."""
        if math.prod(map(len, cases.values())) > MOST_COMBINATIONS:
            self.sampled.update(cases)
        return _combinations(cases)

    def of_outputs(
        self, outputs: Mapping[str, str], message: Any, without: Iterable[str] = ()
    ) -> list[dict[str, Any]]:
        """Return the messages that a mission can tell apart by what it reads of them.

        Args:
            outputs: The variable into which each field is read.
            message: One of this type.
            without: Fields that are given otherwise.
        """
        defaults = default_fields(message, [name for name in outputs if name not in without])
        cases = {name: self.of(outputs[name], value) for name, value in defaults.items()}
        if all(len(values) == 1 for values in cases.values()):
            return [{}]
        return list(self.combinations(cases))

    def message(self, kind: type, fields: Mapping[str, Any]) -> Any:
        """Return a message with these fields, always the same one: nobody writes to it."""
        key = kind, repr(fields)
        if key not in self._messages:
            self._messages[key] = assign(kind(), fields)
        return self._messages[key]

    def message_that(
        self, condition: Expression, kind: type, variables: Mapping[str, Any], *, holds: bool
    ) -> dict[str, Any] | None:
        """Return fields of a message for which a condition holds, or does not.

        None where no combination of the values around its constants does. The condition is asked
        of whole messages, so that it is answered as in a run.
        """
        if id(condition) not in self._names:
            self._names[id(condition)] = tuple({name.name for name in condition.references})
        names = self._names[id(condition)]
        read = [(name, repr(variables[name])) for name in names if name in variables]
        key = id(condition), kind, holds, *read
        if key not in self._met:
            self._met[key] = self._fields_that(condition, kind, variables, holds=holds)
        fields: dict[str, Any] | None = self._met[key]
        return fields

    def _fields_that(
        self, condition: Expression, kind: type, variables: Mapping[str, Any], *, holds: bool
    ) -> dict[str, Any] | None:
        names = list(dict.fromkeys(name.name for name in condition.references if not name.variable))
        defaults = default_fields(kind(), names)
        numbers = [entry.value for entry in _parts(condition.root) if isinstance(entry, Constant)]
        numbers += [variables[name.name] for name in condition.references if name.name in variables]
        cases = {name: _around(default, numbers) for name, default in defaults.items()}
        for fields in _combinations(cases):
            message = assign(kind(), fields)
            try:
                answer = condition.evaluate(variables, None, MessageFields(message))  # type: ignore[arg-type]
            except ExpressionError:
                continue
            if bool(answer) is holds:
                return fields
        self.sampled.add(condition.text)
        return None


def _is_name(part: SyntaxNode) -> bool:
    """Is it a variable or a field: in a requirement, the signal `$name`?"""
    return isinstance(part, Name) or (isinstance(part, SignalValue) and part.name == "$")


def _name_of(part: SyntaxNode) -> str:
    return part.arguments[0] if isinstance(part, SignalValue) else part.name  # type: ignore[attr-defined]


def more_words(fields: Mapping[str, Any]) -> str:
    """Return the values of fields, for people."""
    return "".join(f", {name} = {value!r}" for name, value in fields.items())


def _negated(side: SyntaxNode) -> float | None:
    """Return the number behind a minus; None for anything else."""
    if not isinstance(side, Negation) or side.sign > 0 or not isinstance(side.operand, Constant):
        return None
    value = side.operand.value
    return value if isinstance(value, int | float) else None


def _flows_of(node: NodeModel) -> Iterator[Flow]:
    """Yield which variables a node gives values of others."""
    given: Mapping[str, Any] = {}
    if isinstance(node, SetNode):
        given = node.values
    elif isinstance(node, TreeNode):
        given = node.inputs
        for inner, outer in node.outputs.items():
            yield from ((inner, outer, True), (outer, inner, True))
    for name, value in given.items():
        for expression in _expressions(value):
            root = expression.root
            yield from (
                (_name_of(part), name, part is root) for part in _parts(root) if _is_name(part)
            )


def _values_of(node: NodeModel) -> Iterator[Any]:
    for read in node.reads():
        yield read.value
    if isinstance(node, InterfaceNode):
        yield from node.sent.values()
        if node.condition is not None:
            yield node.condition


def _expressions(value: Any) -> Iterator[Expression]:
    match value:
        case Expression():
            yield value
        case Template():
            yield from (hole.expression for hole in value.holes)
        case Text():
            for reading in (value.template, value.expression):
                if not isinstance(reading, ExpressionError):
                    yield from _expressions(reading)
        case Mapping():
            for part in value.values():
                yield from _expressions(part)
        case list() | tuple():
            for part in value:
                yield from _expressions(part)


def _parts(root: SyntaxNode) -> Iterator[SyntaxNode]:
    yield root
    for part in root.parts:
        yield from _parts(part)


def _combinations(cases: Mapping[str, Sequence[Any]]) -> Iterator[dict[str, Any]]:
    names = list(cases)
    for values in islice(product(*cases.values()), MOST_COMBINATIONS):
        yield dict(zip(names, values, strict=True))


def assign(message: Any, fields: Mapping[str, Any]) -> Any:
    """Return a message after its fields, by dotted names, have got these values.

    A value that does not fit its field leaves it as it is, such as -1 in an unsigned number.
    """
    for dotted, value in fields.items():
        *path, last = dotted.split(".")
        part = message
        for name in path:
            part = getattr(part, name)
        try:
            setattr(part, last, value)
        except (AssertionError, TypeError, ValueError):
            continue
    return message


def default_fields(message: Any, names: Iterable[str]) -> dict[str, Any]:
    """Return the values of these fields, by dotted names; of those that it has."""
    collected = {}
    for name in names:
        try:
            collected[name] = read_field(message, name)
        except AttributeError:
            continue
    return collected


def _around(default: Any, constants: Iterable[Any]) -> tuple[Any, ...]:
    match default:
        case bool():
            return (default, not default)
        case str():
            return (default, *(entry for entry in constants if isinstance(entry, str)), OTHER_TEXT)
        case int() | float():
            kind, collected = type(default), {default: None}
            for number in constants:
                if isinstance(number, int | float) and not isinstance(number, bool):
                    around = (number, number - 1, number + 1, -number, -number - 1, -number + 1)
                    collected |= dict.fromkeys(map(kind, around))
            return tuple(collected)
        case list():
            return (default,)
    return (default,)
