"""What can be wrong with a loaded mission on this machine: worlds, robots, and the ROS types.

Every goal is compared with the fields of its action's type, every condition with the feedback,
every output with the result. Where ROS is not installed a warning says that this was not done.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol

from bt_mission.common import data
from bt_mission.common.faults import Fault, did_you_mean, listed, quoted
from bt_mission.common.located import Document
from bt_mission.mission.check_goal import goal_faults
from bt_mission.mission.expressions import Name
from bt_mission.mission.models import SHORT_NAMES
from bt_mission.mission.scope import Variables, expression_faults, step_faults, walk
from bt_mission.mission.shapes import Message, Path, UnknownField, field_at, value_type
from bt_mission.mission.steps import Action, Mission, Parallel, Step
from bt_mission.mission.values import Type

MOVES_THE_BASE = frozenset(SHORT_NAMES.values())


class UnknownActionType(Protocol):
    """What is raised for an action type that is not installed."""

    message: str
    hint: str | None


@dataclass(frozen=True)
class ActionShapes:
    """What the three messages of an action hold."""

    goal: Message
    result: Message
    feedback: Message


def check(mission: Mission) -> tuple[Fault, ...]:
    """Return every fault of a mission, errors and warnings, in the order of the file.

    The warnings of the loading are among them.
    """
    document = mission.document
    assert document is not None, "a mission to check comes from a file or a text"
    faults = [
        *mission.warnings,
        *_place_faults(document, mission),
        *_base_faults(document, mission),
    ]
    try:
        from bt_mission import ros_types  # noqa: PLC0415 - the rest works without ROS
    except ImportError as error:
        message = f"ROS 2 is not there ({error}), so types and fields were not checked"
        faults.append(
            Fault(message, mission.file, hint="try 'bt-mission doctor'", severity="warning")
        )
    else:
        faults += _Checker(document, mission, ros_types).faults()
    return tuple(sorted(faults, key=lambda fault: (fault.line, fault.column)))


def _place_faults(document: Document, mission: Mission) -> Iterator[Fault]:
    """Yield a fault for a world or robot that is not there."""
    places: tuple[tuple[data.Kind, str, str | None], ...] = (
        ("worlds", "world", mission.world),
        ("robots", "robot", mission.robot),
    )
    for kind, key, wanted in places:
        if wanted is None or data.look_for(kind, wanted, mission.file) is not None:
            continue
        known = data.names(kind)
        message = f"no {key} {quoted(wanted)} (known: {listed(known)})"
        hint = did_you_mean(wanted, known)
        written = document.data.get(key) == wanted
        yield (
            document.fault((key,), message, hint)
            if written
            else Fault(message, f"--{key}", hint=hint)
        )


def _base_faults(document: Document, mission: Mission) -> Iterator[Fault]:
    """Yield a warning for every parallel of which two children move the base."""
    for step in mission.tree.walk():
        if not isinstance(step, Parallel):
            continue
        movers = [child for child in step.children if any(_moves(part) for part in child.walk())]
        if len(movers) > 1:
            message = "two branches of a parallel move the base; the later goal ends the earlier"
            yield document.fault(movers[1].path, message, severity="warning")


def _moves(step: Step) -> bool:
    return isinstance(step, Action) and step.type in MOVES_THE_BASE


class _Checker:
    """Compares the actions of a mission with their types."""

    def __init__(self, document: Document, mission: Mission, ros_types: Any) -> None:
        self.document = document
        self.mission = mission
        self.ros_types = ros_types
        self.known: dict[str, ActionShapes | UnknownActionType] = {}

    def faults(self) -> Iterator[Fault]:
        tree, inputs = self.mission.tree, self.mission.inputs
        for step, variables in walk(tree, inputs, self.output_type):
            yield from step_faults(self.document, step, variables)
            if isinstance(step, Action):
                yield from self.action_faults(step, variables)

    def shapes(self, type_name: str) -> ActionShapes | UnknownActionType:
        """Return the shapes of an action type, or why it is not known."""
        if type_name not in self.known:
            try:
                found = self.ros_types.action_type(type_name)
            except self.ros_types.UnknownType as error:
                self.known[type_name] = error
            else:
                parts = (found.Goal, found.Result, found.Feedback)
                shapes = [self.ros_types.shape_of(part) for part in parts]
                self.known[type_name] = ActionShapes(*shapes)
        return self.known[type_name]

    def output_type(self, step: Action, field: str) -> Type | None:
        shapes = self.shapes(step.type)
        if not isinstance(shapes, ActionShapes):
            return None
        try:
            return value_type(field_at(shapes.result, field))
        except UnknownField:
            return None

    def action_faults(self, step: Action, variables: Variables) -> Iterator[Fault]:
        shapes = self.shapes(step.type)
        if not isinstance(shapes, ActionShapes):
            yield self.type_fault(step, shapes)
            return
        yield from goal_faults(self.document, step, shapes.goal, variables)
        yield from self.condition_faults(step, shapes.feedback, variables)
        yield from self.output_faults(step, shapes.result)

    def type_fault(self, step: Action, error: UnknownActionType) -> Fault:
        if "action" in (self.document.find(step.path).keys or {}):
            path = (*step.path, "action", "type")
            return self.document.fault(path, error.message, error.hint)
        path = (*step.path, step.action.removeprefix("/"))
        return self.document.fault(path, error.message, error.hint, key=True)

    def condition_faults(
        self, step: Action, feedback: Message, variables: Variables
    ) -> Iterator[Fault]:
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
