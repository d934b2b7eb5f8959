"""Everything that can be wrong in the trees of a mission, in one walk over each, and warnings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import islice
from typing import Any

from bt_mission.core.diagnostics import Diagnostic
from bt_mission.core.interface_units import unit_of_field
from bt_mission.core.units import COMPUTED, UNITS
from bt_mission.core.yaml.document import Document
from bt_mission.core.yaml.models import word_for_boolean
from bt_mission.language.checks.comments import cut_texts
from bt_mission.language.checks.conditions import constant_conditions
from bt_mission.language.checks.python_code import leaf_faults
from bt_mission.language.checks.reachability import (
    expected_failures,
    restarted,
    unmoved_loops,
    unreached,
    unsure_cleanups,
)
from bt_mission.language.checks.rules import GoalRules
from bt_mission.language.checks.scope import (
    MOST_ELEMENTS,
    Variables,
    names_read,
    node_faults,
    reference_faults,
    walk,
    written_by,
)
from bt_mission.language.checks.types import FindShapes, TypeChecker, python_faults
from bt_mission.language.expressions.expression import Text
from bt_mission.language.expressions.units import Measured, added_names, is_angle
from bt_mission.language.expressions.values import WORDS, ExpressionError, fits
from bt_mission.language.mission import Mission, Tree
from bt_mission.language.nodes.base import (
    Path,
)
from bt_mission.language.nodes.decorators import TimeoutNode
from bt_mission.language.nodes.interfaces import PARTS_OF, InterfaceNode
from bt_mission.language.nodes.leaves import PythonNode
from bt_mission.language.permissions import ANYTHING, Permissions
from bt_mission.language.trees import used


def scope_faults(mission: Mission) -> Iterator[Diagnostic]:
    """Yield the names that are not known where they stand, and clashes of types.

    Of the fields of messages nothing is known here.
    """
    for tree in mission.all_trees:
        variables = None
        for visit in walk(tree, lambda _node, _field: None):
            node, variables, is_behind = visit
            yield from node_faults(tree.document, visit)
            if is_behind:
                continue
            if isinstance(node, InterfaceNode):
                yield from _message_faults(tree.document, node, variables)
        assert variables is not None, "a tree has a node"
        yield from _promise_faults(tree, variables)


def type_faults(
    mission: Mission,
    find: FindShapes | None,
    rules: GoalRules | None = None,
    permissions: Permissions = ANYTHING,
) -> Iterator[Diagnostic]:
    """Yield everything in a mission that does not fit the types of ROS and of Python behaviours.

    Modules of behaviours are imported where that is permitted. Without `find` the types of messages
    are not known; `rules` say what goals the servers refuse.
    """
    checker = TypeChecker(find, rules, expected_failures(mission))
    for tree in mission.all_trees:
        for follow in tree.follow:
            yield from checker.follow_faults(tree.document, follow)
        for visit in walk(tree, checker.output_type):
            node, variables, is_behind = visit
            yield from node_faults(tree.document, visit)
            if is_behind:
                continue
            if isinstance(node, InterfaceNode):
                found: dict[Diagnostic, None] = {}
                for each in islice(variables.for_each_element(names_read(node)), MOST_ELEMENTS):
                    found |= dict.fromkeys(checker.faults(tree.document, node, each))
                yield from found
            elif isinstance(node, PythonNode) and not any(leaf_faults(tree, node, permissions)):
                yield from python_faults(tree, node, variables)


def _promise_faults(tree: Tree, variables: Variables) -> Iterator[Diagnostic]:
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
            yield tree.document.fault(path, message, key=True)
        elif not fits(types.get(name), wanted):
            message = f"'{name}' is written as {WORDS[types[name]]}, not as {WORDS[wanted]}"
            yield tree.document.fault(path, message, key=True)


def _message_faults(
    document: Document, node: InterfaceNode, variables: Variables
) -> Iterator[Diagnostic]:
    """Yield what is wrong with the names in a node, as far as that is seen without its types."""
    for path, text in _texts(node.sent, (*node.path, *node.sent_path)):
        readings = (text.template, text.expression)
        found = next((one for one in readings if not isinstance(one, Exception)), None)
        if found is None:  # which of the two errors counts, only the field's type can tell
            continue
        marked = [name for name in found.references if name.variable]
        yield from reference_faults(document, path, marked, variables)
        yield from _unit_faults(document, node, path, text, variables)
    if node.condition is not None:
        marked = [name for name in node.condition.references if name.variable]
        path = (*node.path, *node.condition_path)
        yield from reference_faults(document, path, marked, variables, is_on_messages=True)


def _unit_faults(
    document: Document, node: InterfaceNode, path: Path, text: Text, variables: Variables
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
        if not unit or unit not in COMPUTED:
            continue
        size, base = UNITS[value.unit]
        if UNITS[unit][1] != base or (is_angle(unit) and UNITS[unit][0] != size):
            turned = {"deg": "degrees", "rad": "radians"}.get(unit)
            hint = f"write '{turned}({name.shown})'" if turned and UNITS[unit][1] == base else None
            message = f"'{name.shown}' is in {value.unit}, the field is in {unit}"
            yield document.fault(path, message, hint, offset=name.column - 1)


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


def word_inputs(mission: Mission) -> Iterator[Diagnostic]:
    """Yield a warning for each input that is `yes`, `off` or the like, without quotes."""
    for tree in mission.all_trees:
        head = () if tree.is_main else tree.path
        for name, value in tree.inputs.items():
            hint = word_for_boolean(value)
            path = (*head, "inputs", name)
            if hint is None or not _has(tree.document, path[:-1], name):
                continue
            line, column = tree.document.position(path)
            written = tree.document.lines[line - 1][column - 1 :]
            if written.startswith(str(value)):
                message = f"the input '{name}' is the string '{value}'"
                yield tree.document.fault(path, message, hint, severity="warning")


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
    read = frozenset(tree.outputs).union(*(names_read(node) for node in tree.body.walk()))
    head = () if tree.is_main else tree.path
    for name in tree.types:
        if name not in read:
            place = next(one for one in ("inputs", "needs") if _has(document, (*head, one), name))
            message = f"the input '{name}' is never read"
            yield document.fault((*head, place, name), message, key=True, severity="warning")
    for follow in tree.follow:
        if follow.variable not in read:
            message = f"the variable '{follow.variable}' is never read"
            path = (*follow.place.path, "as")
            yield document.fault(path, message, severity="warning")
    yield from unreached(document, tree.body)
    yield from restarted(document, tree.body)
    yield from constant_conditions(document, tree.body)
    yield from cut_texts(document, tree.body)
    yield from unmoved_loops(document, tree)
    yield from unsure_cleanups(document, tree.body)
    timeouts = (node for node in tree.body.walk() if isinstance(node, TimeoutNode))
    bounded = {id(inner) for node in timeouts for inner in node.walk()}
    for node in tree.body.walk():
        endless = node.endless()
        if endless is not None and id(node) not in bounded:
            message = f"{endless} has no timeout: it may take for ever"
            hint = "add 'timeout: SECONDS'"
            yield document.fault(node.path, message, hint, severity="warning")
        for write in node.writes():
            if write.variable not in read:
                message = f"the {write.what} '{write.variable}' is never read"
                path = (*node.path, *write.path)
                yield document.fault(path, message, severity="warning")


def _has(document: Document, path: Path, name: str) -> bool:
    place = document.find(path)
    return name in (place.keys or {})
