"""What can be said of a loaded mission without ROS: names that nobody writes, and warnings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from bt_mission.core.diagnostics import Diagnostic
from bt_mission.core.yaml.document import Document
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.checks.reachability import restarted, unreached
from bt_mission.language.checks.scope import (
    names_read,
    reference_faults,
    step_faults,
    types_at_end,
    walk,
    written_by,
)
from bt_mission.language.checks.variables import Variables
from bt_mission.language.expressions.expression import Expression, Text, Value
from bt_mission.language.expressions.values import WORDS, fits
from bt_mission.language.mission import Mission, Tree
from bt_mission.language.nodes.steps import (
    ActionStep,
    ForEachStep,
    Key,
    PublishStep,
    ServiceStep,
    SetStep,
    Speaker,
    Step,
    WaitForStep,
    Writer,
)
from bt_mission.language.trees import used


def scope_faults(mission: Mission) -> Iterator[Diagnostic]:
    """Yield the names that are not known where they stand, and clashes of types."""
    for tree in mission.all_trees:
        for step, variables in walk(tree, lambda _step, _field: None):
            yield from step_faults(tree.document, step, variables)
            if isinstance(step, Speaker):
                yield from _speaker_faults(tree.document, step, variables)
        yield from _promise_faults(tree)


def _promise_faults(tree: Tree) -> Iterator[Diagnostic]:
    """Yield the outputs of a tree that nothing in it writes, or that have another type."""
    if not tree.outputs:
        return
    written = {name for step in tree.body.walk() for name in written_by(step)}
    types = types_at_end(tree)
    for name, wanted in tree.outputs.items():
        path = (*tree.path, "outputs", name)
        if name not in written | tree.types.keys():
            message = f"nothing in the tree '{tree.name}' writes '{name}'"
            yield tree.document.fault(path, message, key=True)
        elif not fits(types.get(name), wanted):
            message = f"'{name}' is written as {WORDS[types[name]]}, not as {WORDS[wanted]}"
            yield tree.document.fault(path, message, key=True)


def _speaker_faults(
    document: Document, step: Speaker, variables: Variables
) -> Iterator[Diagnostic]:
    """Yield what is wrong with the names in a step, as far as that is seen without its types."""
    for path, text in texts(*sent(document, step)):
        readings = (text.template, text.expression)
        found = next((one for one in readings if not isinstance(one, Exception)), None)
        if found is None:  # which of the two errors counts, only the field's type can tell
            continue
        marked = [name for name in found.references if name.variable]
        yield from reference_faults(document, path, marked, variables)
    path, asked = condition(step)
    if asked is not None:
        marked = [name for name in asked.references if name.variable]
        yield from reference_faults(document, path, marked, variables)


def sent(document: Document, step: Step) -> tuple[Mapping[str, Value], tuple[Key, ...]]:
    """Return the fields that a step sends, of a goal or a request, and where they stand."""
    match step:
        case ActionStep(goal=goal):
            short = short_name(document, step)
            place = ("action", "goal") if short is None else (short,)
            return goal, (*step.path, *place)
        case ServiceStep(request=request):
            return request, (*step.path, "service", "request")
        case PublishStep(message=message):
            return message, (*step.path, "publish", "message")
    return {}, step.path


def condition(step: Step) -> tuple[tuple[Key, ...], Expression | None]:
    """Return where the condition of a step stands, and the condition, if it has one."""
    match step:
        case WaitForStep(until=until):
            return (*step.path, "wait_for", "until"), until
        case ActionStep(cancel_when=cancel_when):
            return (*step.path, "cancel_when"), cancel_when
    return step.path, None


def short_name(document: Document, step: Step) -> str | None:
    """Return the short name that an action is written with, or None."""
    keys = document.find(step.path).keys or {}
    return next((key for key in ACTION_NAMES if key in keys), None)


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


def warnings(mission: Mission) -> Iterator[Diagnostic]:
    """Yield what a mission would better not do, as far as that is seen without ROS.

    Of named trees only those are looked at that the mission uses.
    """
    names = used(mission)
    for tree in mission.all_trees:
        if tree.is_main or tree.name in names:
            yield from _tree_warnings(tree)
    for name, tree in mission.trees.items():
        if name not in names and tree.document is mission.document:
            message = f"the tree '{name}' is never used"
            yield tree.document.fault(tree.path, message, key=True, severity="warning")


def _tree_warnings(tree: Tree) -> Iterator[Diagnostic]:
    document = tree.document
    read = frozenset(tree.outputs).union(*(names_read(step) for step in tree.body.walk()))
    head = () if tree.is_main else tree.path
    for name in tree.types:
        if name not in read:
            place = next(one for one in ("inputs", "needs") if _has(document, (*head, one), name))
            message = f"the input '{name}' is never read"
            yield document.fault((*head, place, name), message, key=True, severity="warning")
    yield from unreached(document, tree.body)
    yield from restarted(document, tree.body)
    for step in tree.body.walk():
        yield from _unlimited(document, step)
        for path, what, name in _written(step):
            if name not in read:
                message = f"the {what} '{name}' is never read"
                yield document.fault(path, message, severity="warning")


def _has(document: Document, path: tuple[Key, ...], name: str) -> bool:
    place = document.find(path)
    return name in (place.keys or {})


def _written(step: Step) -> Iterator[tuple[tuple[Key, ...], str, str]]:
    """Yield where a step writes something, what, and its name."""
    match step:
        case SetStep():
            for name in step.values:
                yield (*step.path, "set", name), "variable", name
        case ForEachStep(variable=name):
            yield (*step.path, "for_each", name), "variable", name
        case Writer():
            for result_field, name in step.outputs.items():
                yield (*step.path, "outputs", result_field), "output", name


def _unlimited(document: Document, step: Step) -> Iterator[Diagnostic]:
    """Yield a warning for what may take for ever."""
    match step:
        case ActionStep(timeout=None):
            what = step.action
        case WaitForStep(timeout=None):
            what = f"the wait for {step.topic}"
        case _:
            return
    message = f"{what} has no timeout: it may take for ever"
    yield document.fault(step.path, message, "add 'timeout: SECONDS'", severity="warning")
