"""Everything that can be wrong in the trees of a mission, in one walk over each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import islice
from typing import Any

from bt_mission.base.diagnostics import MOST_DIAGNOSTICS, Diagnostic
from bt_mission.base.units import COMPUTED, UNITS
from bt_mission.language.checks.scope import (
    Variables,
    Visit,
    node_diagnostics,
    reference_diagnostics,
    walk,
    written_by,
)
from bt_mission.language.checks.types import GoalRules, TypeChecker
from bt_mission.language.checks.warnings import expected_failures
from bt_mission.language.expressions.expression import Text
from bt_mission.language.expressions.units import Measured, added_names, is_angle
from bt_mission.language.expressions.values import WORDS, ExpressionError, fits
from bt_mission.language.interface_units import SI, unit_of_field
from bt_mission.language.message_types import FindShapes
from bt_mission.language.mission import Mission, Tree
from bt_mission.language.nodes.base import Path
from bt_mission.language.nodes.interfaces import PARTS_OF, InterfaceNode
from bt_mission.language.nodes.leaves import PythonNode
from bt_mission.language.permissions import Permissions


def tree_diagnostics(
    mission: Mission,
    find: FindShapes | None = None,
    rules: GoalRules | None = None,
    permissions: Permissions | None = None,
) -> list[Diagnostic]:
    """Return what is wrong with the nodes of a mission, at most `MOST_DIAGNOSTICS`.

    Args:
        mission: As it could be read.
        find: Looks up the types of ROS; without it nothing is known of fields of messages.
        rules: Say what goals the servers refuse.
        permissions: What becomes of Python leaves; without it they are not looked at.
    """
    checker = TypeChecker(find, rules, expected_failures(mission) if rules else frozenset())
    diagnostics = (
        diagnostic
        for tree in mission.all_trees
        for diagnostic in _diagnostics_in(tree, checker, permissions)
    )
    return list(islice(diagnostics, MOST_DIAGNOSTICS))


def _diagnostics_in(
    tree: Tree, checker: TypeChecker, permissions: Permissions | None
) -> Iterator[Diagnostic]:
    for follow in tree.follow:
        yield from checker.follow_diagnostics(tree.document, follow)
    for visit in walk(tree, checker.output_type):
        yield from dict.fromkeys(_node_diagnostics(tree, visit, checker, permissions))
    yield from _promise_diagnostics(tree, visit.variables)


def _node_diagnostics(
    tree: Tree, visit: Visit, checker: TypeChecker, permissions: Permissions | None
) -> Iterator[Diagnostic]:
    node, variables, is_behind = visit
    yield from node_diagnostics(visit)
    if isinstance(node, InterfaceNode) and not is_behind:
        yield from _message_diagnostics(node, variables)
        yield from checker.diagnostics(node, variables)
    elif isinstance(node, PythonNode) and permissions is not None:
        from bt_mission.language.checks.python_code import (  # noqa: PLC0415 - few have Python
            leaf_diagnostics,
        )

        yield from leaf_diagnostics(tree, node, permissions, variables)


def _promise_diagnostics(tree: Tree, variables: Variables) -> Iterator[Diagnostic]:
    """Yield the outputs of a tree that nothing in it writes, or that have another type.

    `variables` are those behind its last node.
    """
    if not tree.outputs:
        return
    written = {name for node in tree.body.walk() for name in written_by(node)}
    written.update(variables.followed)
    types = variables.types
    for name, wanted in tree.outputs.items():
        path = (*tree.path, "outputs", name)
        if name not in written | tree.types.keys():
            message = f"no node of the tree '{tree.name}' assigns '{name}'"
            yield tree.document.diagnostic("BT-213", path, message, key=True)
        elif not fits(types.get(name), wanted):
            message = f"'{name}' is written as {WORDS[types[name]]}, not as {WORDS[wanted]}"
            yield tree.document.diagnostic("BT-213", path, message, key=True)


def _message_diagnostics(node: InterfaceNode, variables: Variables) -> Iterator[Diagnostic]:
    """Yield what is wrong with the names in a node, as far as that is seen without its types."""
    for path, text in _texts(node.sent, (*node.path, *node.sent_path)):
        readings = (text.template, text.expression)
        expression = next(
            (reading for reading in readings if not isinstance(reading, Exception)), None
        )
        if expression is None:  # which of the two errors counts, only the field's type can tell
            continue
        marked = [name for name in expression.references if name.variable]
        yield from reference_diagnostics(path, marked, variables)
        yield from _unit_diagnostics(node, path, text, variables)
    if node.condition is not None:
        marked = [name for name in node.condition.references if name.variable]
        path = (*node.path, *node.condition_path)
        yield from reference_diagnostics(path, marked, variables, is_on_messages=True)


def _unit_diagnostics(
    node: InterfaceNode, path: Path, text: Text, variables: Variables
) -> Iterator[Diagnostic]:
    """Yield the inputs in an expression whose unit is another one than that of the field."""
    if isinstance(text.expression, ExpressionError):
        return
    field = path[len(node.path) + len(node.sent_path) :]
    for name in added_names(text.expression.root):
        value = variables.inputs.get(name.name)
        if not isinstance(value, Measured):
            continue
        unit = unit_of_field(node.type, PARTS_OF[node.interface][0], field)
        unit = UNITS[value.unit][1] if unit == SI else unit
        if not unit or unit not in COMPUTED:
            continue
        size, base = UNITS[value.unit]
        if UNITS[unit][1] != base or (is_angle(unit) and UNITS[unit][0] != size):
            turned = {"deg": "degrees", "rad": "radians"}.get(unit)
            hint = f"write '{turned}({name.shown})'" if turned and UNITS[unit][1] == base else None
            message = f"'{name.shown}' is in {value.unit}, the field is in {unit}"
            yield variables.diagnostic(path, ExpressionError("BT-305", message, name.column, hint))


def _texts(value: Any, path: Path) -> Iterator[tuple[Path, Text]]:
    """Yield the texts in a goal, each with its path."""
    match value:
        case Text():
            yield path, value
        case Mapping():
            for key, part in value.items():
                yield from _texts(part, (*path, key))
        case list() | tuple():
            for index, part in enumerate(value):
                yield from _texts(part, (*path, index))
