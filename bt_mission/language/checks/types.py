"""The actions, services and topics of a mission against their types."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from bt_mission.core.diagnostics import Diagnostic, listed, quoted
from bt_mission.core.yaml.document import Document
from bt_mission.language.checks.goals import goal_faults
from bt_mission.language.checks.scope import expression_faults, step_faults, walk
from bt_mission.language.checks.variables import Variables
from bt_mission.language.checks.warnings import condition, sent, short_name
from bt_mission.language.expressions.syntax import Name
from bt_mission.language.expressions.values import Type
from bt_mission.language.message_types import (
    ActionShapes,
    MessageShape,
    Path,
    ServiceShapes,
    UnknownField,
    UnknownType,
    field_at,
    value_type,
)
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.steps import ActionStep, PublishStep, Speaker

Shapes = ActionShapes | ServiceShapes | MessageShape
FindShapes = Callable[[str], Shapes]
"""Gives what a type holds, by its full name. Raises UnknownType."""


def type_faults(mission: Mission, find: FindShapes) -> Iterator[Diagnostic]:
    """Yield everything in a mission that does not fit its types."""
    known: dict[str, _Talk | UnknownType] = {}
    for tree in mission.all_trees:
        checker = _Checker(tree.document, find, known)
        for step, variables in walk(tree, checker.output_type):
            yield from step_faults(tree.document, step, variables)
            if isinstance(step, Speaker):
                yield from checker.faults(step, variables)


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


class _Checker:
    """Compares steps with their types, each type looked up once."""

    def __init__(
        self, document: Document, find: FindShapes, known: dict[str, _Talk | UnknownType]
    ) -> None:
        self.document = document
        self.find = find
        self.known = known

    def talk(self, step: Speaker) -> _Talk | UnknownType:
        """Return the messages of a step, or why they are not known."""
        if step.type not in self.known:
            try:
                self.known[step.type] = _talk(self.find(step.type))
            except UnknownType as error:
                self.known[step.type] = error
        return self.known[step.type]

    def output_type(self, step: Speaker, field: str) -> Type | None:
        """Return the type of a field that a step keeps; None where there is no such field."""
        talk = self.talk(step)
        if isinstance(talk, UnknownType):
            return None
        try:
            return value_type(field_at(talk.keeps, field))
        except UnknownField:
            return None

    def faults(self, step: Speaker, variables: Variables) -> Iterator[Diagnostic]:
        """Yield everything in one step that does not fit its type."""
        talk = self.talk(step)
        if isinstance(talk, UnknownType):
            yield self.type_fault(step, talk)
            return
        sends = talk.keeps if isinstance(step, PublishStep) else talk.sends
        if sends is not None:
            values, path = sent(self.document, step)
            yield from goal_faults(self.document, path, values, sends, variables)
        if talk.asks is not None:
            yield from self.condition_faults(step, talk.asks, variables)
        yield from self.output_faults(step, talk.keeps)

    def type_fault(self, step: Speaker, error: UnknownType) -> Diagnostic:
        """Return the fault of a step whose type is not installed."""
        short = short_name(self.document, step)
        if short is not None:
            return self.document.fault((*step.path, short), error.message, error.hint, key=True)
        return self.document.fault((*step.path, step.kind, "type"), error.message, error.hint)

    def condition_faults(
        self, step: Speaker, message: MessageShape, variables: Variables
    ) -> Iterator[Diagnostic]:
        """Yield what is wrong with a condition on the feedback, or on the message of a topic."""
        path, asked = condition(step)
        if asked is None:
            return

        def field_type(name: str) -> Type | None:
            try:
                return value_type(field_at(message, name))
            except UnknownField:
                raise KeyError(name) from None

        bare = [name for name in asked.references if not name.variable]
        unknown = list(self.unknown_names(path, bare, message, variables))
        yield from unknown
        if unknown:
            return
        yield from expression_faults(self.document, path, asked, variables, "bool", field_type)
        if not any(name.name.partition(".")[0] in message.fields for name in bare):
            what = "the feedback" if isinstance(step, ActionStep) else message.name
            text = f"the condition reads no field of {what} ({listed(message.fields)})"
            yield self.document.fault(path, text)

    def unknown_names(
        self, path: Path, names: list[Name], message: MessageShape, variables: Variables
    ) -> Iterator[Diagnostic]:
        """Yield the bare names of a condition that name no value, of a field or a variable."""
        for name in names:
            offset = name.column - 1
            try:
                shape = field_at(message, name.name)
            except UnknownField as error:
                if name.name not in variables.types:
                    yield self.document.fault(path, error.message, error.hint, offset=offset)
                continue
            if isinstance(shape, MessageShape):
                yield self.document.fault(path, _too_much(name.name, shape), offset=offset)

    def output_faults(self, step: Speaker, kept: MessageShape) -> Iterator[Diagnostic]:
        """Yield the outputs that a result, response or message does not have."""
        for field in step.outputs:
            path = (*step.path, "outputs", field)
            try:
                shape = field_at(kept, field)
            except UnknownField as error:
                yield self.document.fault(path, error.message, error.hint, key=True)
                continue
            if isinstance(shape, MessageShape):
                yield self.document.fault(path, _too_much(field, shape), key=True)


def _too_much(field: str, shape: MessageShape) -> str:
    fields = listed(f"{field}.{name}" for name in shape.fields)
    return f"{quoted(field)} is a {shape.name}; name one of its fields: {fields}"
