"""Python code that a mission brings: may it be used, is it there, can it be imported?"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from bt_mission.base.diagnostics import Diagnostic, describe, did_you_mean, listed, quoted
from bt_mission.base.errors import described
from bt_mission.base.yaml.document import Document, Key
from bt_mission.language.checks.scope import Variables, expression_diagnostics
from bt_mission.language.expressions.expression import Expression
from bt_mission.language.expressions.values import WORDS, fits, type_of
from bt_mission.language.mission import NodeFactory, Tree
from bt_mission.language.nodes.leaves import PythonNode
from bt_mission.language.permissions import Permissions
from bt_mission.language.plugins import (
    PythonError,
    attributes_of,
    find_class,
    find_factory,
    find_program,
    locate,
    program_of,
)

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour


def factory_diagnostics(
    factories: Iterable[NodeFactory], permissions: Permissions, *, is_needed: bool = True
) -> Iterator[Diagnostic]:
    """Yield what is wrong with factories of nodes; those that are needed are imported."""
    for factory in factories:
        mistakes = [
            *_code_diagnostics(factory.document, factory.path, factory.target, "node", permissions)
        ]
        yield from mistakes
        if is_needed and permissions.python == "import" and not mistakes:
            try:
                find = find_program if program_of(factory.target) else find_factory
                find(factory.target, factory.file)
            except PythonError as error:
                yield factory.diagnostic(error.code, error.message, error.hint)


def _code_diagnostics(
    document: Document, path: tuple[Key, ...], target: str, what: str, permissions: Permissions
) -> Iterator[Diagnostic]:
    if permissions.python == "refuse":
        message = f"the Python {what} {quoted(target)} is refused"
        yield document.diagnostic("BT-216", path, message, permissions.hint)
        return
    try:
        locate(target, document.file, permissions.folders, is_node=what == "node")
    except PythonError as error:
        yield document.diagnostic(error.code, path, error.message, error.hint)
        return
    if permissions.python == "name":
        message = f"Python code, which was not imported: {quoted(target)}"
        yield document.diagnostic("BT-217", path, message, permissions.hint, severity="warning")


def _construction_diagnostics(
    kind: type[Behaviour], node: PythonNode, document: Document
) -> Iterator[Diagnostic]:
    """Construct a leaf; yield what its constructor raises."""
    from bt_mission.base.clock_watch import CONTAINED  # noqa: PLC0415 - for users' code alone

    try:
        with CONTAINED:
            kind(node.label)
    except Exception as error:  # noqa: BLE001 - whatever a user's code raises
        message = f"{kind.__name__}({node.label!r}) raised {described(error, kind)}"
        yield document.diagnostic("BT-913", (*node.path, "python"), message)


def leaf_diagnostics(
    tree: Tree, node: PythonNode, permissions: Permissions, variables: Variables
) -> Iterator[Diagnostic]:
    """Yield what is wrong with a Python leaf and its use; its module is imported if it may be."""
    document, place = tree.document, (*node.path, "python")
    mistakes = [*_code_diagnostics(document, place, node.target, "leaf", permissions)]
    yield from mistakes
    if mistakes or permissions.python != "import":
        return
    try:
        kind = find_class(node.target, document.file)
    except PythonError as error:
        yield document.diagnostic(error.code, place, error.message, error.hint)
        return
    if permissions.constructs:
        yield from _construction_diagnostics(kind, node, document)
    attributes = attributes_of(kind)
    known = listed(attributes) if attributes else "none"
    for key, names in (("inputs", node.inputs), ("outputs", node.outputs)):
        for name in names:
            if name not in attributes:
                path = (*node.path, key, name)
                message = f"no attribute {quoted(name)} on {kind.__name__} (it declares: {known})"
                yield document.diagnostic(
                    "BT-215", path, message, did_you_mean(name, attributes), key=True
                )
    for name, value in node.inputs.items():
        wanted, path = attributes.get(name), (*node.path, "inputs", name)
        if wanted is not None and isinstance(value, Expression):
            yield from expression_diagnostics(path, value, variables, wanted)
        elif wanted is not None and not fits(type_of(value), wanted):
            yield document.diagnostic(
                "BT-301", path, f"expected {WORDS[wanted]}, got {describe(value)}"
            )
