"""The actions of a mission against their types: goals, conditions and outputs."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from bt_mission.common.faults import Fault, listed, quoted
from bt_mission.common.located import Document
from bt_mission.mission.check_goal import goal_faults
from bt_mission.mission.expressions import Name
from bt_mission.mission.scope import Variables, expression_faults, step_faults, walk
from bt_mission.mission.shapes import (
    ActionShapes,
    Message,
    Path,
    UnknownField,
    UnknownType,
    field_at,
    value_type,
)
from bt_mission.mission.steps import Action, Mission
from bt_mission.mission.values import Type

FindShapes = Callable[[str], ActionShapes]
"""Gives the shapes of an action type by its full name. Raises UnknownType."""


def type_faults(
    document: Document,
    mission: Mission,
    find: FindShapes,
    lost: frozenset[str] = frozenset(),
) -> Iterator[Fault]:
    """Yield everything in a mission that does not fit the types of its actions.

    `lost` are outputs of nodes that could not be read.
    """
    checker = _Checker(document, find)
    for step, variables in walk(mission.tree, mission.inputs, checker.output_type, lost):
        yield from step_faults(document, step, variables)
        if isinstance(step, Action):
            yield from checker.action_faults(step, variables)


class _Checker:
    """Compares actions with their types, each type looked up once."""

    def __init__(self, document: Document, find: FindShapes) -> None:
        self.document = document
        self.find = find
        self.known: dict[str, ActionShapes | UnknownType] = {}

    def shapes(self, type_name: str) -> ActionShapes | UnknownType:
        """Return the shapes of an action type, or why they are not known."""
        if type_name not in self.known:
            try:
                self.known[type_name] = self.find(type_name)
            except UnknownType as error:
                self.known[type_name] = error
        return self.known[type_name]

    def output_type(self, step: Action, field: str) -> Type | None:
        """Return the type of a result field; None where there is no such field."""
        shapes = self.shapes(step.type)
        if isinstance(shapes, UnknownType):
            return None
        try:
            return value_type(field_at(shapes.result, field))
        except UnknownField:
            return None

    def action_faults(self, step: Action, variables: Variables) -> Iterator[Fault]:
        """Yield everything in one action that does not fit its type."""
        shapes = self.shapes(step.type)
        if isinstance(shapes, UnknownType):
            yield self.type_fault(step, shapes)
            return
        yield from goal_faults(self.document, step, shapes.goal, variables)
        yield from self.condition_faults(step, shapes.feedback, variables)
        yield from self.output_faults(step, shapes.result)

    def type_fault(self, step: Action, error: UnknownType) -> Fault:
        """Return the fault of an action whose type is not installed."""
        if "action" in (self.document.find(step.path).keys or {}):
            path = (*step.path, "action", "type")
            return self.document.fault(path, error.message, error.hint)
        path = (*step.path, step.action.removeprefix("/"))
        return self.document.fault(path, error.message, error.hint, key=True)

    def condition_faults(
        self, step: Action, feedback: Message, variables: Variables
    ) -> Iterator[Fault]:
        """Yield what is wrong with a condition on the feedback."""
        if step.cancel_when is None:
            return
        path = (*step.path, "cancel_when")

        def field_type(name: str) -> Type | None:
            try:
                return value_type(field_at(feedback, name))
            except UnknownField:
                raise KeyError(name) from None

        bare = [name for name in step.cancel_when.references if not name.variable]
        unknown = list(self.unknown_names(path, bare, feedback, variables))
        yield from unknown
        if unknown:
            return
        yield from expression_faults(
            self.document, path, step.cancel_when, variables, "bool", field_type
        )
        if not any(name.name.partition(".")[0] in feedback.fields for name in bare):
            message = f"the condition reads no field of the feedback ({listed(feedback.fields)})"
            yield self.document.fault(path, message)

    def unknown_names(
        self, path: Path, names: list[Name], feedback: Message, variables: Variables
    ) -> Iterator[Fault]:
        """Yield the bare names of a condition that are no field of the feedback, nor variables."""
        for name in names:
            try:
                field_at(feedback, name.name)
            except UnknownField as error:
                if name.name not in variables.types:
                    offset = name.column - 1
                    yield self.document.fault(path, error.message, error.hint, offset=offset)

    def output_faults(self, step: Action, result: Message) -> Iterator[Fault]:
        """Yield the outputs that the result does not have."""
        for field in step.outputs:
            path = (*step.path, "outputs", field)
            try:
                shape = field_at(result, field)
            except UnknownField as error:
                yield self.document.fault(path, error.message, error.hint, key=True)
                continue
            if isinstance(shape, Message):
                message = f"{quoted(field)} is a {shape.name}; name one of its fields: "
                message += listed(f"{field}.{name}" for name in shape.fields)
                yield self.document.fault(path, message, key=True)
