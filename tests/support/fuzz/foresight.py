"""What the check could have known of a mission's failure: a second opinion, at more leisure."""

from __future__ import annotations

import re
from collections.abc import Iterator
from random import Random
from typing import Any

from bt_mission.executive.behaviours.runtime import Scope
from bt_mission.language.checks.scope import Variables, walk
from bt_mission.language.expressions.expression import Expression, Template, Text
from bt_mission.language.expressions.syntax import EvaluationScope as Known
from bt_mission.language.expressions.syntax import FunctionCall, Name, SyntaxNode
from bt_mission.language.expressions.values import ExpressionError, Type, fits, type_of
from bt_mission.language.follow import Follow
from bt_mission.language.message_types import UnknownField, field_at, value_type
from bt_mission.language.mission import Mission, Tree
from bt_mission.language.nodes.base import NodeModel, Written
from bt_mission.language.nodes.interfaces import InterfaceNode
from bt_mission.language.nodes.leaves import SetNode
from bt_mission.ros import interface_types

_CLASH = re.compile(
    r"expected (a whole number(?! of at least)|a number|true or false|a text|a list|a mapping)\b"
    r".*, got "
    r"|cannot compare|compares numbers, got|not a boolean"
)
_ELEMENT = re.compile(r"\.\d+(\.\w+)*: expected ")


def foreseeable(mission: Mission, scope: Scope, text: str) -> str | None:
    """Return what is wrong where the failure of a mission could have been known beforehand."""
    for tree in mission.all_trees:
        for step, variables, _ in walk(tree, _output_type):
            if text.startswith(f"{tree.document.file}:{step.line}:{step.column}: "):
                return _unseen(tree, step, variables, scope, text)
    return "a failure without a place"


def _unseen(
    tree: Tree, step: NodeModel, variables: Variables, scope: Scope, text: str
) -> str | None:
    expressions = list(_expressions(step))
    constants = tree.constants
    for expression in expressions:
        for part in _fixed(expression.root, constants.keys()):
            message = _error_of(part, constants)
            if message is not None and message in text:
                return f"known beforehand, {step.kind}"
    if all(
        expression.names <= constants.keys() and not expression.draws for expression in expressions
    ):
        return f"all values are known, {step.kind}"
    lacking = re.search(r"'\$?([A-Za-z_]\w*)' has no value", text)
    if lacking and lacking[1] not in variables.types:
        return f"a name that is not known, {step.kind}"
    inside_a_list = _ELEMENT.search(text)
    if (
        _CLASH.search(text)
        and not inside_a_list
        and all(_type(expression, step, variables) is not None for expression in expressions)
    ):
        return f"a clash of known types, {step.kind}"
    if tree.is_main:
        for name, believed in variables.types.items():
            value = scope.values.get(name)
            if believed is not None and name in scope.values and not fits(type_of(value), believed):
                return f"a wrong belief, {step.kind}"
    return None


def _type(expression: Expression, step: NodeModel, variables: Variables) -> Type | None:
    """Return the type of an expression where no part of it is in doubt."""
    types = dict(variables.types)
    if isinstance(step, SetNode):
        for name, value in step.values.items():
            types[name] = variables.type_of(value)

    def known(name: Name) -> Type | None:
        return types.get(name.name) if name.variable or name.name in types else None

    if any(known(name) is None for name in expression.references):
        return None
    if any(_infer(part, known) is None for part in _parts(expression.root)):
        return None
    if any(isinstance(part, FunctionCall) for part in _parts(expression.root)):
        return None
    return _infer(expression.root, known)


def _infer(part: SyntaxNode, known: Any) -> Type | None:
    try:
        return part.infer(known)
    except ExpressionError:
        return None


def _parts(node: SyntaxNode) -> Iterator[SyntaxNode]:
    yield node
    for part in node.parts:
        yield from _parts(part)


def _fixed(node: SyntaxNode, known: Any) -> Iterator[SyntaxNode]:
    """Yield the parts of an expression that have the same value in every run."""
    for part in _parts(node):
        inner = list(_parts(part))
        drawn = any(
            isinstance(inner_part, FunctionCall) and inner_part.draws for inner_part in inner
        )
        if not drawn and all(
            inner_part.name in known for inner_part in inner if isinstance(inner_part, Name)
        ):
            yield part


def _error_of(part: SyntaxNode, constants: Any) -> str | None:
    try:
        part.evaluate(Known(constants, {}, Random(0)))
    except ExpressionError as error:
        return error.message
    return None


def _expressions(value: Any) -> Iterator[Expression]:
    """Yield every expression in a step, those of the steps below it left out."""
    if isinstance(value, Expression):
        yield value
    elif isinstance(value, Template):
        yield from (hole.expression for hole in value.holes)
    else:
        for part in _inside(value):
            yield from _expressions(part)


def _inside(value: Any) -> Iterator[Any]:
    match value:
        case Text():
            yield from (value.template, value.expression)
        case Written():
            below = ("child", "children", "otherwise")
            names = (name for name in type(value).model_fields if name not in below)
            yield from (getattr(value, name) for name in names)
        case dict():
            yield from value.values()
        case list() | tuple():
            yield from value


def _output_type(step: InterfaceNode | Follow, name: str) -> Type | None:
    try:
        return value_type(field_at(interface_types.shapes(step.type).keeps, name))
    except UnknownField:
        return None
