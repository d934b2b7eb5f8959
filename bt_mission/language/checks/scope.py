"""Which names are known where, of what type, and what an expression does with them.

Variables are the inputs, which never change, and the outputs of steps that stand earlier in
the file. That an earlier step has really written its outputs, only the run can tell.
"""

from __future__ import annotations

import random
from collections import ChainMap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from bt_mission.core.diagnostics import Diagnostic, describe, quoted
from bt_mission.core.yaml.document import Document
from bt_mission.language.checks.variables import Variables
from bt_mission.language.expressions.constants import evaluate_constants
from bt_mission.language.expressions.expression import Expression, Template, Value, names_in
from bt_mission.language.expressions.syntax import Name
from bt_mission.language.expressions.values import ExpressionError, Type
from bt_mission.language.mission import Tree
from bt_mission.language.nodes.fields import LIMIT, SECONDS, TIMES, NumberRule
from bt_mission.language.nodes.steps import (
    ActionStep,
    CheckStep,
    ForEachStep,
    GuardStep,
    Key,
    LogStep,
    PublishStep,
    PythonStep,
    RepeatStep,
    RetryStep,
    ServiceStep,
    SetStep,
    Speaker,
    Step,
    SubtreeStep,
    TimeoutStep,
    WaitForStep,
    WaitStep,
    WhenStep,
    Writer,
)

OutputType = Callable[[Speaker, str], Type | None]
"""The type of a field that a step reads; None where it is not known."""

FieldType = Callable[[str], Type | None]
"""The type of a field of a message by its dotted name; raises KeyError where there is none."""


def walk(tree: Tree, output_type: OutputType) -> Iterator[tuple[Step, Variables]]:
    """Yield every step of a tree in the order of the file, with the variables known at it."""
    lines: dict[str, int] = {}
    for step in tree.body.walk():
        for name in written_by(step):
            lines.setdefault(name, step.line)
    known: dict[str, Type | None] = dict.fromkeys(sorted(tree.lost))
    known |= tree.types
    variables = Variables(tree.constants, known, lines, frozenset(tree.types))
    yield from _walk(tree.body, variables, output_type)


def types_at_end(tree: Tree) -> Mapping[str, Type | None]:
    """Return the types of a tree's variables behind its last step; of messages nothing is known."""
    (*_, (_, variables)) = walk(tree, lambda _step, _field: None)
    return variables.types


def _walk(
    step: Step, variables: Variables, output_type: OutputType
) -> Iterator[tuple[Step, Variables]]:
    yield step, variables
    if not isinstance(step, ForEachStep):
        for name, found in _written(step, variables, output_type):
            variables.note(name, found)
        for below in step.steps:
            yield from _walk(below, variables, output_type)
        return
    types, loops, name = variables.types, variables.loops, step.variable
    # That a name is taken already is a fault of its own; it then keeps what it was.
    shadowed = {name: types[name]} if name in types else {}
    around = {name: loops[name]} if name in loops else {}
    types[name] = variables.element_type(step.elements)
    loops[name] = step.line
    yield from _walk(step.child, variables, output_type)
    del types[name]
    variables.left[name] = loops.pop(name)
    types.update(shadowed)
    loops.update(around)


def _written(
    step: Step, variables: Variables, output_type: OutputType
) -> Iterator[tuple[str, Type | None]]:
    """Yield the variables that a step writes, each with its type as far as it is known."""
    match step:
        case SubtreeStep():
            yield from ((name, step.gives.get(field)) for field, name in step.outputs.items())
        case Speaker():
            yield from ((name, output_type(step, field)) for field, name in step.outputs.items())
        case Writer():
            yield from ((name, None) for name in step.outputs.values())
        case SetStep():
            yield from ((name, variables.type_of(value)) for name, value in step.values.items())


def written_by(step: Step) -> tuple[str, ...]:
    """Return the variables that a step writes for the steps behind it."""
    match step:
        case Writer():
            return tuple(step.outputs.values())
        case SetStep():
            return tuple(step.values)
    return ()


def values_of(step: Step) -> Iterator[tuple[tuple[Key, ...], Value, NumberRule]]:
    """Yield the numbers of a step: path in the document, value, rule. Goals are left out."""
    path = step.path
    match step:
        case RepeatStep():
            yield (*path, "repeat", "count"), step.count, TIMES
        case RetryStep():
            yield (*path, "retry", "attempts"), step.attempts, TIMES
            yield (*path, "retry", "pause"), step.pause, SECONDS
        case WaitStep():
            yield (*path, "wait"), step.seconds, SECONDS
        case TimeoutStep():
            yield (*path, "timeout"), step.seconds, LIMIT
        case ServiceStep() | WaitForStep():
            if step.timeout is not None:
                yield (*path, "timeout"), step.timeout, LIMIT
        case ActionStep():
            if step.timeout is not None:
                yield (*path, "timeout"), step.timeout, LIMIT
            if step.silence_timeout is not None:
                yield (*path, "silence_timeout"), step.silence_timeout, LIMIT


def asked_of(step: Step) -> Iterator[tuple[tuple[Key, ...], Expression, Type | None]]:
    """Yield what a step asks of variables: path in the document, expression, the type it needs.

    Numbers with a rule, goals, requests, `set`, and conditions on messages are left out.
    """
    match step:
        case GuardStep(condition=Expression() as condition):
            yield (*step.path, "guard"), condition, "bool"
        case WhenStep(condition=Expression() as condition):
            yield (*step.path, "when"), condition, "bool"
        case CheckStep(condition=Expression() as condition):
            yield (*step.path, "check"), condition, "bool"
        case ForEachStep(elements=Expression() as elements):
            yield (*step.path, "for_each", step.variable), elements, "list"
        case SubtreeStep() | PythonStep():
            at = ("tree", "inputs") if isinstance(step, SubtreeStep) else ("inputs",)
            takes = step.takes if isinstance(step, SubtreeStep) else {}
            for name, value in step.inputs.items():
                if isinstance(value, Expression):
                    yield (*step.path, *at, name), value, takes.get(name)


def step_faults(document: Document, step: Step, variables: Variables) -> Iterator[Diagnostic]:
    """Yield what is wrong with the names and types in a step, goals and conditions left out."""
    for path, value, rule in values_of(step):
        if isinstance(value, Expression):
            yield from number_faults(document, path, value, variables, rule)
    if isinstance(step, LogStep):
        path = (*step.path, "log")
        yield from template_faults(document, path, step.message, variables)
    if isinstance(step, SetStep):
        # Each value may read what the ones before it have set.
        variables = replace(variables, types=ChainMap({}, variables.types))
        for name, value in step.values.items():
            if isinstance(value, Expression):
                path = (*step.path, "set", name)
                yield from expression_faults(document, path, value, variables, None)
            variables.note(name, variables.type_of(value))
    for path, expression, wanted in asked_of(step):
        yield from expression_faults(document, path, expression, variables, wanted)
    yield from _naming_faults(document, step, variables)


def _naming_faults(document: Document, step: Step, variables: Variables) -> Iterator[Diagnostic]:
    """Yield the variables that a step must not write."""
    match step:
        case Writer():
            for result_field, name in step.outputs.items():
                why = variables.fixed(name)
                if why is not None:
                    yield document.fault((*step.path, "outputs", result_field), why)
        case SetStep():
            for name in step.values:
                why = variables.fixed(name)
                if why is not None:
                    yield document.fault((*step.path, "set", name), why, key=True)
        case ForEachStep(variable=name):
            if name in variables.types:
                message = f"'{name}' is a variable already; choose another name"
                yield document.fault((*step.path, "for_each", name), message, key=True)


def number_faults(
    document: Document,
    path: Sequence[Key],
    value: Expression,
    variables: Variables,
    rule: NumberRule,
) -> Iterator[Diagnostic]:
    """Yield what is wrong with an expression that must give a number."""
    if value.draws or not variables.fixes(value.names):
        yield from expression_faults(
            document, path, value, variables, rule.type, expected=rule.words
        )
        return
    try:
        result = value.evaluate(variables.inputs, random.Random(0))
    except ExpressionError as error:
        yield located(document, path, error)
        return
    if not rule.allows(result):
        yield document.fault(path, rule.refuses(describe(result), result))


def expression_faults(
    document: Document,
    path: Sequence[Key],
    value: Expression,
    variables: Variables,
    wanted: Type | None,
    field_type: FieldType | None = None,
    offset: int = 0,
    expected: str | None = None,
) -> Iterator[Diagnostic]:
    """Yield the names in an expression that are not known, or else the clash of types in it.

    `expected` says in words what stands here; one loose word is measured by it.
    """
    root = value.root
    if expected and isinstance(root, Name) and not root.variable:
        unknown = variables.unknown(root)
        if unknown is not None:
            message = f"expected {expected}, got {quoted(root.name)}, which {unknown[0]}"
            yield document.fault(path, message, unknown[1], offset=offset)
            return
    faults = list(reference_faults(document, path, value.references, variables, field_type, offset))
    yield from faults
    if faults:
        return

    def is_field(name: Name) -> bool:
        return field_type is not None and _has(field_type, name.name)

    def type_at(name: Name) -> Type | None:
        if field_type is not None and not name.variable and is_field(name):
            return field_type(name.name)
        return variables.types.get(name.name)

    def is_constant(name: Name) -> bool:
        return name.name in variables.inputs and (name.variable or not is_field(name))

    try:
        if wanted is None:
            value.infer(type_at)
        else:
            value.root.expect(type_at, wanted)
        evaluate_constants(value.root, variables.inputs, is_constant, wanted)
    except ExpressionError as error:
        yield located(document, path, error, offset)


def reference_faults(
    document: Document,
    path: Sequence[Key],
    references: Iterable[Name],
    variables: Variables,
    field_type: FieldType | None = None,
    offset: int = 0,
) -> Iterator[Diagnostic]:
    """Yield a fault for every name that is neither a field nor a variable known here."""
    for name in references:
        if field_type is not None and not name.variable and _has(field_type, name.name):
            continue
        unknown = variables.unknown(name)
        if unknown is not None:
            message = f"'{name.shown}' {unknown[0]}"
            yield document.fault(path, message, unknown[1], offset=name.column - 1 + offset)


def _has(field_type: FieldType, name: str) -> bool:
    try:
        field_type(name)
    except KeyError:
        return False
    return True


def template_faults(
    document: Document, path: Sequence[Key], value: Template, variables: Variables
) -> Iterator[Diagnostic]:
    """Yield what is wrong with the names in a template."""
    for offset, expression in value.expressions:
        yield from expression_faults(document, path, expression, variables, None, offset=offset)


def located(
    document: Document, path: Sequence[Key], error: ExpressionError, offset: int = 0
) -> Diagnostic:
    """Return an error in an expression as a fault at its place in the document."""
    return document.fault(path, error.message, error.hint, offset=error.column - 1 + offset)


def names_read(step: Step) -> frozenset[str]:
    """Return every variable that a step may read."""
    read = [names_in(value) for _, value, _ in values_of(step)]
    read += [value.names for _, value, _ in asked_of(step)]
    if isinstance(step, SetStep):
        read += [names_in(value) for value in step.values.values()]
    if isinstance(step, LogStep):
        read.append(step.message.names)
    if isinstance(step, ActionStep):
        read += [names_in(step.goal), names_in(step.cancel_when)]
    if isinstance(step, ServiceStep):
        read.append(names_in(step.request))
    if isinstance(step, WaitForStep):
        read.append(step.until.names)
    if isinstance(step, PublishStep):
        read.append(names_in(step.message))
    return frozenset().union(*read)
