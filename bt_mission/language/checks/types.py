"""The actions, services and topics of a mission against the types of their messages."""

from __future__ import annotations

import random
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import Any, Protocol

from bt_mission.base.diagnostics import MOST_DIAGNOSTICS, Diagnostic, describe, listed
from bt_mission.base.yaml.document import Document
from bt_mission.language.checks.scope import (
    MOST_ELEMENTS,
    Variables,
    expression_diagnostics,
    names_read,
    template_diagnostics,
)
from bt_mission.language.expressions.expression import Expression, Late, Template, Text
from bt_mission.language.expressions.outcomes import Range, outcomes
from bt_mission.language.expressions.syntax import Name, SyntaxNode
from bt_mission.language.expressions.values import (
    WORDS,
    ExpressionError,
    LooseText,
    Type,
    fits,
    type_of,
)
from bt_mission.language.follow import Follow
from bt_mission.language.message_types import (
    SHORTHANDS,
    FindShapes,
    InterfaceShapes,
    ListOf,
    MessageShape,
    Path,
    Scalar,
    Shape,
    TypeMismatch,
    Unknowable,
    UnknownField,
    UnknownType,
    completed,
    conform,
    field_at,
    too_much,
    value_type,
)
from bt_mission.language.nodes.interfaces import InterfaceNode
from bt_mission.language.nodes.remedies import beside

Ranges = Mapping[str, tuple[float, float]]
"""From where to where numbers can go, by their names."""


class GoalRules(Protocol):
    """The goals of a mission as far as they are known before they are sent.

    `values` are the fields of a goal as their message holds them, those that are not written as 0,
    false or empty; None stands for a value that only the run can tell.
    """

    def diagnostics(
        self, document: Document, node: InterfaceNode, values: Mapping[str, Any]
    ) -> Iterable[Diagnostic]:
        """Return why a server refuses the goal of a node, and what is suspicious in it."""

    def feedback(self, node: InterfaceNode, values: Mapping[str, Any]) -> Ranges:
        """Return from where to where the numbers of the feedback can go."""


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
        self._known: dict[str, InterfaceShapes | UnknownType] = {}

    def _shapes(self, node: InterfaceNode | Follow) -> InterfaceShapes | UnknownType | None:
        """Return the messages of a node or a topic, or why they are not known."""
        if self._find is not None and node.type not in self._known:
            try:
                self._known[node.type] = self._find(node.type)
            except UnknownType as error:
                self._known[node.type] = error
        return self._known.get(node.type)

    def output_type(self, node: InterfaceNode | Follow, field: str) -> Type | None:
        """Return the type of a field that is kept; None where there is no such field."""
        shapes = self._shapes(node)
        if not isinstance(shapes, InterfaceShapes):
            return None
        try:
            return value_type(field_at(shapes.keeps, field))
        except UnknownField:
            return None

    def diagnostics(self, node: InterfaceNode, variables: Variables) -> Iterator[Diagnostic]:
        """Yield everything in one node that does not fit its type, for each element of a loop."""
        shapes = self._shapes(node)
        if isinstance(shapes, UnknownType):
            path, is_key = (*node.path, *node.type_path), node.type_path[-1] != "type"
            yield variables.document.diagnostic(
                shapes.code, path, shapes.message, shapes.hint, key=is_key
            )
        if isinstance(shapes, InterfaceShapes):
            for each in islice(variables.for_each_element(names_read(node)), MOST_ELEMENTS):
                yield from self._misfits(node, shapes, each)

    def _misfits(
        self, node: InterfaceNode, shapes: InterfaceShapes, variables: Variables
    ) -> Iterator[Diagnostic]:
        ranges: Ranges = {}
        if node.sent_path:
            reader = _GoalReader((*node.path, *node.sent_path), variables, node.keys)
            values = conform(shapes.sends, node.sent, reader.read, reader.report)
            yield from reader.diagnostics
            if self._rules is not None and not reader.diagnostics:
                whole = completed(shapes.sends, values)
                for diagnostic in self._rules.diagnostics(variables.document, node, whole):
                    is_expected = id(node) in self._expected_failures
                    yield replace(diagnostic, severity="warning") if is_expected else diagnostic
                ranges = self._rules.feedback(node, whole)
        if shapes.asks is not None and node.condition is not None:
            diagnostics = list(_condition_diagnostics(node, node.condition, shapes.asks, variables))
            yield from diagnostics or _settled_condition(node, node.condition, ranges, variables)
        for write in node.writes():
            path, field = (*node.path, *write.path), str(write.path[-1])
            yield from _field_diagnostics(
                variables.document, path, field, shapes.keeps, is_key=True
            )

    def follow_diagnostics(self, document: Document, follow: Follow) -> Iterator[Diagnostic]:
        """Yield what does not fit the type of a topic in a variable that follows it."""
        shapes, path, settings = self._shapes(follow), follow.place.path, follow.settings
        if isinstance(shapes, UnknownType):
            yield document.diagnostic(shapes.code, (*path, "type"), shapes.message, shapes.hint)
        if not isinstance(shapes, InterfaceShapes):
            return
        diagnostics = [
            *_field_diagnostics(document, (*path, "field"), settings.field, shapes.keeps)
        ]
        yield from diagnostics
        wanted = None if diagnostics else value_type(field_at(shapes.keeps, settings.field))
        for key, value in (("initial", settings.initial), ("default", settings.default)):
            if wanted is not None and value is not None and not fits(type_of(value), wanted):
                message = f"expected {WORDS[wanted]}, as the field has, got {describe(value)}"
                yield document.diagnostic("BT-503", (*path, key), message)


def _condition_diagnostics(
    node: InterfaceNode, asked: Expression, message: MessageShape, variables: Variables
) -> Iterator[Diagnostic]:
    """Yield what is wrong with a condition on the feedback, or on the message of a topic."""
    path = (*node.path, *node.condition_path)
    diagnostics = list(expression_diagnostics(path, asked, variables, "bool", message))
    yield from diagnostics
    read = {name.name.partition(".")[0] for name in asked.references if not name.variable}
    if not diagnostics and message.fields.keys().isdisjoint(read):
        if node.interface == "action" and not variables.given.issuperset(asked.names):
            return
        what = "the feedback" if node.interface == "action" else message.name
        text = f"the condition reads no field of {what} ({listed(message.fields)})"
        yield variables.document.diagnostic("BT-506", path, text)


def _field_diagnostics(
    document: Document, path: Path, field: str, kept: MessageShape, *, is_key: bool = False
) -> Iterator[Diagnostic]:
    """Yield what is wrong with a field that is kept of a result, a response or a message."""
    try:
        shape = field_at(kept, field)
    except UnknownField as error:
        yield document.diagnostic(error.code, path, error.message, error.hint, key=is_key)
        return
    if isinstance(shape, MessageShape):
        yield document.diagnostic("BT-502", path, too_much(field, shape), key=is_key)


def _settled_condition(
    node: InterfaceNode, condition: Expression, ranges: Ranges, variables: Variables
) -> Iterator[Diagnostic]:
    """Yield a warning for a condition on feedback that comes to the same for all of a goal."""
    if not ranges:
        return

    def find(name: SyntaxNode) -> Range | None:
        if not isinstance(name, Name):
            return None
        if not name.variable and name.name in ranges:
            return ranges[name.name]
        value = variables.inputs.get(name.name)
        if isinstance(value, bool) or not isinstance(value, int | float):
            return None
        return float(value), float(value)

    values = outcomes(condition.root, find)
    if len(values) > 1:
        return
    read = dict.fromkeys(name.name for name in condition.references if name.name in ranges)
    if not read:
        return
    reach = " and ".join(f"'{name}' {_words(ranges[name])}" for name in read)
    path = (*node.path, *node.condition_path)
    if True in values:
        message = f"this condition is true from the first feedback: with this goal {reach}"
    else:
        message = f"this condition is never true: with this goal {reach}"
    yield variables.document.diagnostic("BT-507", path, message, severity="warning")


def _words(ends: Range) -> str:
    low, high = ends
    if high == float("inf"):
        return f"is {low:g} or more"
    return f"goes from about {low:g} to {high:g}"


# ---- goals, requests and messages that are sent ---------------------------------------------


@dataclass
class _GoalReader:
    """Reads the texts of a goal, request or message as their fields want them.

    Args:
        at: Where it stands.
        variables: Those known there.
        modifiers: The keys that may stand beside it.
        diagnostics: What is wrong with it; the values are then of no use.
    """

    at: Path
    variables: Variables
    modifiers: Collection[str]
    diagnostics: list[Diagnostic] = field(default_factory=list)

    def report(self, problem: TypeMismatch) -> None:
        if len(self.diagnostics) >= MOST_DIAGNOSTICS:
            return
        path, hint = (*self.at, *problem.path), problem.hint
        if problem.at_key and len(problem.path) == 1 and problem.path[0] in self.modifiers:
            hint = beside(str(problem.path[0]), str(self.at[-1]))
        document = self.variables.document
        self.diagnostics.append(
            document.diagnostic(problem.code, path, problem.message, hint, key=problem.at_key)
        )

    def read(self, path: Path, shape: Shape, text: Text | Late) -> Any:
        """Return the value that a text has in every run. Raises Unknowable where it varies."""
        assert isinstance(text, Text), "a loaded goal holds nothing that is resolved"
        if len(self.diagnostics) >= MOST_DIAGNOSTICS:
            raise Unknowable
        at, is_text = (*self.at, *path), isinstance(shape, Scalar) and shape.type == "text"
        reading = text.template if is_text else text.expression
        try:
            if isinstance(reading, ExpressionError):
                raise reading
            is_fixed = not reading.draws and self.variables.fixes(reading.names)
            if isinstance(reading, Template):
                diagnostics = [*template_diagnostics(at, reading, self.variables)]
            elif is_fixed:
                diagnostics = []
            else:
                words, wanted = _wanted(shape)
                diagnostics = [
                    *expression_diagnostics(at, reading, self.variables, wanted, expected=words)
                ]
            self.diagnostics += diagnostics
            if is_fixed and not diagnostics:
                return reading.evaluate(self.variables.inputs, random.Random(0))
        except ExpressionError as error:
            if isinstance(error, LooseText):
                message = f"expected {_wanted(shape)[0]} or an expression: {error.message}"
                error = ExpressionError(error.code, message, error.column, error.hint)
            self.diagnostics.append(self.variables.diagnostic(at, error))
        raise Unknowable


def _wanted(shape: Shape) -> tuple[str, Type | None]:
    """Return in words what a field takes, and the type an expression for it must have."""
    match shape:
        case Scalar():
            return f"{WORDS[shape.type]} ({shape.name})", shape.type
        case ListOf():
            return f"a list ({shape.name})", "list"
    if shape.name in SHORTHANDS:
        return SHORTHANDS[shape.name]
    return f"a mapping ({shape.name})", None
