"""Python code that a mission brings: may it be used, is it there, can it be imported?"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from bt_mission.core.diagnostics import Diagnostic, quoted
from bt_mission.core.yaml.document import Document, Key
from bt_mission.language.mission import Mission, NodeFactory, Tree
from bt_mission.language.nodes.leaves import PythonNode
from bt_mission.language.permissions import Permissions
from bt_mission.language.plugins import PythonError, find_factory, locate


def code_faults(
    mission: Mission, permissions: Permissions, *, has_stage: bool = True
) -> Iterator[Diagnostic]:
    """Yield the Python leaves and nodes that may not be used, are not there, or are only named.

    Args:
        has_stage: Is the mission for a simulation? Its nodes are imported then.
    """
    yield from factory_faults(mission.nodes, permissions, is_needed=has_stage)
    for tree in mission.all_trees:
        for node in tree.body.walk():
            if isinstance(node, PythonNode):
                yield from leaf_faults(tree, node, permissions)


def factory_faults(
    factories: Iterable[NodeFactory], permissions: Permissions, *, is_needed: bool = True
) -> Iterator[Diagnostic]:
    """Yield what is wrong with factories of nodes; those that are needed are imported."""
    for one in factories:
        found = [*_code_faults(one.document, one.path, one.target, "node", permissions)]
        yield from found
        if is_needed and permissions.python == "import" and not found:
            try:
                find_factory(one.target, one.file)
            except PythonError as error:
                yield one.fault(error.message, error.hint)


def leaf_faults(tree: Tree, node: PythonNode, permissions: Permissions) -> Iterator[Diagnostic]:
    """Yield what is wrong with a Python leaf, as far as that is seen without importing it."""
    path = (*node.path, "python")
    yield from _code_faults(tree.document, path, node.target, "leaf", permissions)


def _code_faults(
    document: Document, path: tuple[Key, ...], target: str, what: str, permissions: Permissions
) -> Iterator[Diagnostic]:
    if permissions.python == "refuse":
        message = f"the Python {what} {quoted(target)} is refused"
        yield document.fault(path, message, permissions.hint)
        return
    try:
        locate(target, document.file, permissions.folders)
    except PythonError as error:
        yield document.fault(path, error.message, error.hint)
        return
    if permissions.python == "name":
        message = f"Python code, which was not imported: {quoted(target)}"
        yield document.fault(path, message, permissions.hint, severity="warning")
