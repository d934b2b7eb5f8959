"""What of a mission cannot change while its tree runs: the nodes, and what is fixed of each."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import zip_longest

from bt_mission.core.diagnostics import Diagnostic
from bt_mission.language.mission import Mission, Tree
from bt_mission.language.nodes.base import NodeModel
from bt_mission.language.trees import used


def frame_change(before: Mission, after: Mission) -> Diagnostic | None:
    """Return the first place at which another version of a mission needs another tree, if any.

    Where there is none, the nodes of the first one's tree can go by the second.
    """
    return next(_frame_changes(before, after), None)


def _frame_changes(before: Mission, after: Mission) -> Iterator[Diagnostic]:
    if _followed(before) != _followed(after):
        yield after.main.document.fault(("follow",), "other variables follow topics")
    yield from _node_changes(before.tree, after.tree, after.main)
    for name in used(before):
        one, other = before.trees[name], after.trees.get(name)
        if other is None:
            yield after.main.document.fault(("trees",), f"there is no tree '{name}'")
            continue
        if _signature(one) != _signature(other):
            message = f"the tree '{name}' has other inputs, outputs or variables"
            yield other.document.fault(other.path, message, key=True)
        yield from _node_changes(one.body, other.body, other)


def _node_changes(before: NodeModel, after: NodeModel, tree: Tree) -> Iterator[Diagnostic]:
    waiting: list[tuple[NodeModel | None, NodeModel | None, NodeModel]] = [(before, after, after)]
    while waiting:
        one, other, parent = waiting.pop()
        if one is None or other is None or one.frame != other.frame:
            yield tree.document.fault((other or parent).path, _difference(one, other))
            return
        below = zip_longest(one.below, other.below)
        waiting += reversed([(*pair, other) for pair in below])


def _difference(before: NodeModel | None, after: NodeModel | None) -> str:
    if before is None:
        return "a node more than before"
    if after is None:
        return f"the node '{before.label}' is gone"
    return f"another node than '{before.label}', or one that is built in another way"


def _signature(tree: Tree) -> tuple[object, ...]:
    return (tree.inputs, tree.types, tree.outputs, _followed(tree))


def _followed(part: Mission | Tree) -> list[object]:
    return [one.settings for one in part.follow]
