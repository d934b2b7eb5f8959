"""What can be said of a loaded mission without ROS: names that nobody writes, and warnings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from bt_mission.common.faults import Fault
from bt_mission.common.located import Document
from bt_mission.mission.expressions import Text
from bt_mission.mission.scope import Variables, names_read, reference_faults, step_faults, walk
from bt_mission.mission.steps import Action, Key, Mission


def scope_faults(
    document: Document, mission: Mission, lost: frozenset[str] = frozenset()
) -> Iterator[Fault]:
    """Yield the names that are not known where they stand, and clashes of types.

    `lost` are outputs of nodes that could not be read.
    """
    for step, variables in walk(mission.tree, mission.inputs, lambda _action, _field: None, lost):
        yield from step_faults(document, step, variables)
        if isinstance(step, Action):
            yield from _action_faults(document, step, variables)


def _action_faults(document: Document, step: Action, variables: Variables) -> Iterator[Fault]:
    """Yield what is wrong with an action's names, as far as that is seen without its types."""
    for path, text in texts(step.goal, goal_path(document, step)):
        readings = (text.template, text.expression)
        found = next((one for one in readings if not isinstance(one, Exception)), None)
        if found is None:  # which of the two errors counts, only the field's type can tell
            continue
        marked = [name for name in found.references if name.variable]
        yield from reference_faults(document, path, marked, variables)
    if step.cancel_when is not None:
        path = (*step.path, "cancel_when")
        marked = [name for name in step.cancel_when.references if name.variable]
        yield from reference_faults(document, path, marked, variables)
    for result_field, variable in step.outputs.items():
        if variable in variables.inputs:
            path = (*step.path, "outputs", result_field)
            message = f"'{variable}' is an input, and inputs never change; choose another name"
            yield document.fault(path, message)


def goal_path(document: Document, step: Action) -> tuple[Key, ...]:
    """Return where an action's goal stands in the document."""
    if "action" in (document.find(step.path).keys or {}):
        return (*step.path, "action", "goal")
    return (*step.path, step.action.removeprefix("/"))


def texts(value: Any, path: tuple[Key, ...]) -> Iterator[tuple[tuple[Key, ...], Text]]:
    """Yield the texts in a goal, each with its path."""
    match value:
        case Text():
            yield path, value
        case Mapping():
            for key, part in value.items():
                yield from texts(part, (*path, key))
        case list() | tuple():
            for index, part in enumerate(value):
                yield from texts(part, (*path, index))


def warnings(document: Document, mission: Mission) -> Iterator[Fault]:
    """Yield what a mission would better not do, as far as that is seen without ROS."""
    read = frozenset().union(*(names_read(step) for step in mission.tree.walk()))
    for name in mission.inputs:
        if name not in read:
            message = f"the input '{name}' is never read"
            yield document.fault(("inputs", name), message, key=True, severity="warning")
    for step in mission.tree.walk():
        if not isinstance(step, Action):
            continue
        if step.timeout is None:
            message = f"{step.action} has no timeout: it may take for ever"
            hint = "add 'timeout: SECONDS'"
            yield document.fault(step.path, message, hint, severity="warning")
        for result_field, variable in step.outputs.items():
            if variable not in read:
                message = f"the output '{variable}' is never read"
                path = (*step.path, "outputs", result_field)
                yield document.fault(path, message, severity="warning")
