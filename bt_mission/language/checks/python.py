"""The Python behaviours of a mission: whether they are there, and take and give what it says."""

from __future__ import annotations

from collections.abc import Iterator

from bt_mission.core.diagnostics import Diagnostic, describe, did_you_mean, listed, quoted
from bt_mission.language.checks.scope import expression_faults, walk
from bt_mission.language.checks.variables import Variables
from bt_mission.language.expressions.expression import Expression
from bt_mission.language.expressions.values import WORDS, Type, fits, type_of
from bt_mission.language.mission import Mission, Tree
from bt_mission.language.nodes.steps import PythonStep
from bt_mission.language.plugins import PythonError, attributes_of, find_class


def python_faults(mission: Mission) -> Iterator[Diagnostic]:
    """Yield what is wrong with the uses of Python behaviours. Their modules are imported."""
    for tree in mission.all_trees:
        for step, variables in walk(tree, lambda _step, _field: None):
            if isinstance(step, PythonStep):
                yield from _faults(tree, step, variables)


def _faults(tree: Tree, step: PythonStep, variables: Variables) -> Iterator[Diagnostic]:
    document, place = tree.document, (*step.path, "python")
    try:
        kind = find_class(step.target, document.file)
    except PythonError as error:
        yield document.fault(place, error.message, error.hint)
        return
    attributes = attributes_of(kind)
    known = listed(attributes) if attributes else "none"
    for name, value in step.inputs.items():
        path = (*step.path, "inputs", name)
        if name not in attributes:
            message = f"no attribute {quoted(name)} on {kind.__name__} (it declares: {known})"
            yield document.fault(path, message, did_you_mean(name, attributes), key=True)
        elif isinstance(value, Expression):
            wanted = attributes[name]
            if wanted is not None:
                yield from expression_faults(document, path, value, variables, wanted)
        else:
            yield from _constant_faults(tree, path, value, attributes[name])
    for name in step.outputs:
        if name not in attributes:
            path = (*step.path, "outputs", name)
            message = f"no attribute {quoted(name)} on {kind.__name__} (it declares: {known})"
            yield document.fault(path, message, did_you_mean(name, attributes), key=True)


def _constant_faults(
    tree: Tree, path: tuple[str | int, ...], value: object, wanted: Type | None
) -> Iterator[Diagnostic]:
    if wanted is not None and not fits(type_of(value), wanted):
        message = f"expected {WORDS[wanted]}, got {describe(value)}"
        yield tree.document.fault(path, message)
