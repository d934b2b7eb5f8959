"""What a loaded mission would better not do, as far as that is seen without ROS."""

from __future__ import annotations

from collections.abc import Iterator

from bt_mission.core.diagnostics import Diagnostic
from bt_mission.core.yaml.document import Document
from bt_mission.language.checks.reachability import restarted, unreached
from bt_mission.language.checks.scope import names_read
from bt_mission.language.mission import Mission, Tree
from bt_mission.language.nodes.base import Key
from bt_mission.language.trees import used


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
    yield from unreached(document, tree.body)
    yield from restarted(document, tree.body)
    for node in tree.body.walk():
        endless = node.endless()
        if endless is not None:
            message = f"{endless} has no timeout: it may take for ever"
            hint = "add 'timeout: SECONDS'"
            yield document.fault(node.path, message, hint, severity="warning")
        for write in node.writes():
            if write.variable not in read:
                message = f"the {write.what} '{write.variable}' is never read"
                path = (*node.path, *write.path)
                yield document.fault(path, message, severity="warning")


def _has(document: Document, path: tuple[Key, ...], name: str) -> bool:
    place = document.find(path)
    return name in (place.keys or {})
