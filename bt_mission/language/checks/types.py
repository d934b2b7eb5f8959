"""The actions, services, topics and Python behaviours of a mission against their types."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from bt_mission.core.diagnostics import Diagnostic, describe, did_you_mean, listed, quoted
from bt_mission.core.yaml.document import Document
from bt_mission.language.checks.conditions import settled_condition
from bt_mission.language.checks.goals import read_goal
from bt_mission.language.checks.rules import GoalRules, Ranges
from bt_mission.language.checks.scope import Variables, expression_faults
from bt_mission.language.expressions.expression import Expression
from bt_mission.language.expressions.syntax import Name
from bt_mission.language.expressions.values import WORDS, Type, fits, type_of
from bt_mission.language.follow import Follow
from bt_mission.language.message_types import (
    ActionShapes,
    MessageShape,
    Path,
    ServiceShapes,
    UnknownField,
    UnknownType,
    completed,
    field_at,
    value_type,
)
from bt_mission.language.mission import Tree
from bt_mission.language.nodes.interfaces import InterfaceNode
from bt_mission.language.nodes.leaves import PythonNode
from bt_mission.language.plugins import PythonError, attributes_of, find_class

Shapes = ActionShapes | ServiceShapes | MessageShape
FindShapes = Callable[[str], Shapes]
"""Gives what a type holds, by its full name. Raises UnknownType."""


@dataclass(frozen=True)
class _Talk:
    """The messages of one step: what it sends, what its condition reads, what it can keep."""

    sends: MessageShape | None
    asks: MessageShape | None
    keeps: MessageShape


def _talk(shapes: Shapes) -> _Talk:
    match shapes:
        case ActionShapes():
            return _Talk(shapes.goal, shapes.feedback, shapes.result)
        case ServiceShapes():
            return _Talk(shapes.request, None, shapes.response)
    return _Talk(None, shapes, shapes)


class TypeChecker:
    """Compares nodes with the types of their messages, each type looked up once.

    `rules` say what goals the servers refuse; without them only types are compared. Of the nodes
    that are expected to fail, by their `id`, it is no more than a warning.
    """

    def __init__(
        self,
        find: FindShapes | None,
        rules: GoalRules | None = None,
        expected_failures: frozenset[int] = frozenset(),
    ) -> None:
        self._find = find
        self._rules = rules
        self._expected_failures = expected_failures
        self._known: dict[str, _Talk | UnknownType] = {}

    def _talk(self, node: InterfaceNode | Follow) -> _Talk | UnknownType | None:
        """Return the messages of a node or a topic, or why they are not known."""
        if self._find is not None and node.type not in self._known:
            try:
                self._known[node.type] = _talk(self._find(node.type))
            except UnknownType as error:
                self._known[node.type] = error
        return self._known.get(node.type)

    def output_type(self, node: InterfaceNode | Follow, field: str) -> Type | None:
        """Return the type of a field that is kept; None where there is no such field."""
        talk = self._talk(node)
        if not isinstance(talk, _Talk):
            return None
        try:
            return value_type(field_at(talk.keeps, field))
        except UnknownField:
            return None

    def faults(
        self, document: Document, node: InterfaceNode, variables: Variables
    ) -> Iterator[Diagnostic]:
        """Yield everything in one node that does not fit its type."""
        talk = self._talk(node)
        if isinstance(talk, UnknownType):
            path = (*node.path, *node.type_path)
            is_key = node.type_path[-1] != "type"
            yield document.fault(path, talk.message, talk.hint, key=is_key)
        if not isinstance(talk, _Talk):
            return
        ranges: Ranges = {}
        if node.sent_path:
            # What is published is a message of the topic, which others would read.
            sends = talk.keeps if talk.sends is None else talk.sends
            path = (*node.path, *node.sent_path)
            values, faults = read_goal(document, path, node.sent, sends, variables, node.keys)
            yield from faults
            if self._rules is not None and not faults:
                whole = completed(sends, values)
                for fault in self._rules.faults(document, node, whole):
                    is_expected = id(node) in self._expected_failures
                    yield replace(fault, severity="warning") if is_expected else fault
                ranges = self._rules.feedback(node, whole)
        if talk.asks is not None and node.condition is not None:
            faults = list(_condition_faults(document, node, talk.asks, variables))
            yield from faults or settled_condition(document, node, ranges, variables)
        yield from _output_faults(document, node, talk.keeps)

    def follow_faults(self, document: Document, follow: Follow) -> Iterator[Diagnostic]:
        """Yield what does not fit the type of a topic in a variable that follows it."""
        talk, path, settings = self._talk(follow), follow.place.path, follow.settings
        if isinstance(talk, UnknownType):
            yield document.fault((*path, "type"), talk.message, talk.hint)
        if not isinstance(talk, _Talk):
            return
        fault = _field_fault(document, (*path, "field"), settings.field, talk.keeps)
        if fault is not None:
            yield fault
            return
        wanted = value_type(field_at(talk.keeps, settings.field))
        for key, value in (("initial", settings.initial), ("default", settings.default)):
            if wanted is not None and value is not None and not fits(type_of(value), wanted):
                message = f"expected {WORDS[wanted]}, as the field has, got {describe(value)}"
                yield document.fault((*path, key), message)


def _condition_faults(
    document: Document, node: InterfaceNode, message: MessageShape, variables: Variables
) -> Iterator[Diagnostic]:
    """Yield what is wrong with a condition on the feedback, or on the message of a topic."""
    path, asked = (*node.path, *node.condition_path), node.condition
    assert asked is not None

    def field_type(name: str) -> Type | None:
        try:
            return value_type(field_at(message, name))
        except UnknownField:
            raise KeyError(name) from None

    bare = [name for name in asked.references if not name.variable]
    unknown = list(_unknown_names(document, path, bare, message, variables))
    yield from unknown
    if unknown:
        return
    faults = list(expression_faults(document, path, asked, variables, "bool", field_type))
    yield from faults
    if not faults and not any(name.name.partition(".")[0] in message.fields for name in bare):
        if node.interface == "action" and not variables.given.issuperset(asked.names):
            return
        what = "the feedback" if node.interface == "action" else message.name
        text = f"the condition reads no field of {what} ({listed(message.fields)})"
        yield document.fault(path, text)


def _unknown_names(
    document: Document,
    path: Path,
    names: list[Name],
    message: MessageShape,
    variables: Variables,
) -> Iterator[Diagnostic]:
    """Yield the bare names of a condition that name no value, of a field or a variable."""
    for name in names:
        offset = name.column - 1
        try:
            shape = field_at(message, name.name)
        except UnknownField as error:
            if name.name not in variables.types:
                yield document.fault(path, error.message, error.hint, offset=offset)
            continue
        if isinstance(shape, MessageShape):
            yield document.fault(path, _too_much(name.name, shape), offset=offset)


def _output_faults(
    document: Document, node: InterfaceNode, kept: MessageShape
) -> Iterator[Diagnostic]:
    """Yield the outputs that a result, response or message does not have."""
    for write in node.writes():
        path, field = (*node.path, *write.path), str(write.path[-1])
        fault = _field_fault(document, path, field, kept, is_key=True)
        if fault is not None:
            yield fault


def _field_fault(
    document: Document, path: Path, field: str, kept: MessageShape, *, is_key: bool = False
) -> Diagnostic | None:
    """Return what is wrong with a field that is kept of a message, or None."""
    try:
        shape = field_at(kept, field)
    except UnknownField as error:
        return document.fault(path, error.message, error.hint, key=is_key)
    if isinstance(shape, MessageShape):
        return document.fault(path, _too_much(field, shape), key=is_key)
    return None


def _too_much(field: str, shape: MessageShape) -> str:
    fields = listed(f"{field}.{name}" for name in shape.fields)
    return f"{quoted(field)} is a {shape.name}; name one of its fields: {fields}"


def python_faults(tree: Tree, node: PythonNode, variables: Variables) -> Iterator[Diagnostic]:
    """Yield what is wrong with the use of a Python behaviour, whose module is imported."""
    document, place = tree.document, (*node.path, "python")
    try:
        kind = find_class(node.target, document.file)
    except PythonError as error:
        yield document.fault(place, error.message, error.hint)
        return
    attributes = attributes_of(kind)
    known = listed(attributes) if attributes else "none"
    for name, value in node.inputs.items():
        path = (*node.path, "inputs", name)
        if name not in attributes:
            message = f"no attribute {quoted(name)} on {kind.__name__} (it declares: {known})"
            yield document.fault(path, message, did_you_mean(name, attributes), key=True)
        elif isinstance(value, Expression):
            wanted = attributes[name]
            if wanted is not None:
                yield from expression_faults(document, path, value, variables, wanted)
        else:
            yield from _constant_faults(tree, path, value, attributes[name])
    for name in node.outputs:
        if name not in attributes:
            path = (*node.path, "outputs", name)
            message = f"no attribute {quoted(name)} on {kind.__name__} (it declares: {known})"
            yield document.fault(path, message, did_you_mean(name, attributes), key=True)


def _constant_faults(
    tree: Tree, path: tuple[str | int, ...], value: object, wanted: Type | None
) -> Iterator[Diagnostic]:
    if wanted is not None and not fits(type_of(value), wanted):
        message = f"expected {WORDS[wanted]}, got {describe(value)}"
        yield tree.document.fault(path, message)
