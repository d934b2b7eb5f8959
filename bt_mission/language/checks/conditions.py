"""Conditions that always come to the same: constants, and what feedback cannot reach."""

from __future__ import annotations

import random
from collections.abc import Iterator

from bt_mission.core.diagnostics import Diagnostic
from bt_mission.core.yaml.document import Document
from bt_mission.language.checks.rules import Ranges
from bt_mission.language.checks.scope import Variables
from bt_mission.language.expressions.expression import Expression
from bt_mission.language.expressions.outcomes import Range, outcomes
from bt_mission.language.expressions.syntax import Name, SyntaxNode
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.language.nodes.base import ConditionalNode, NodeModel
from bt_mission.language.nodes.interfaces import InterfaceNode
from bt_mission.language.nodes.leaves import CheckNode

_CONSEQUENCES = {
    ("when", True): "'do' is always run",
    ("when", False): "'do' is never run",
    ("guard", True): "it guards nothing",
    ("guard", False): "'do' is never run",
    ("check", True): "it always succeeds",
    ("check", False): "it always fails",
}


def constant_conditions(document: Document, tree: NodeModel) -> Iterator[Diagnostic]:
    """Yield a warning for every condition that reads nothing, so that it asks nothing.

    `check: false` is how a mission fails on purpose, so a plain truth value of `check` is none.
    """
    for node in tree.walk():
        if not isinstance(node, ConditionalNode):
            continue
        value = _constant(node)
        if value is None:
            continue
        what = "always holds" if value else "never holds"
        message = f"this condition {what}: {_CONSEQUENCES[node.kind, value]}"
        hint = "let it read a variable, such as '$count > 2'"
        path = (*node.path, node.kind)
        yield document.fault(path, message, hint, severity="warning")


def _constant(node: ConditionalNode) -> bool | None:
    """Return what a condition comes to in every run, where it reads nothing."""
    condition = node.condition
    if not isinstance(condition, Expression):
        return None if isinstance(node, CheckNode) else condition
    if condition.references or condition.draws:
        return None
    try:
        value = condition.evaluate({}, random.Random(0))
    except ExpressionError:
        return None
    return value if isinstance(value, bool) else None


def settled_condition(
    document: Document, node: InterfaceNode, ranges: Ranges, variables: Variables
) -> Iterator[Diagnostic]:
    """Yield a warning for a condition on feedback that comes to the same for all of a goal."""
    condition = node.condition
    if condition is None or not ranges:
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

    found = outcomes(condition.root, find)
    if len(found) > 1:
        return
    read = dict.fromkeys(name.name for name in condition.references if name.name in ranges)
    if not read:
        return
    reach = " and ".join(f"'{name}' {_words(ranges[name])}" for name in read)
    path = (*node.path, *node.condition_path)
    if True in found:
        message = f"this condition holds from the first feedback on: with this goal {reach}"
    else:
        message = f"this condition never holds: with this goal {reach}"
    yield document.fault(path, message, severity="warning")


def _words(ends: Range) -> str:
    low, high = ends
    if high == float("inf"):
        return f"is {low:g} or more"
    return f"goes from about {low:g} to {high:g}"
