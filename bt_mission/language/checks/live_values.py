"""Values that change in BehaviorTree.CPP while a node runs, but not here.

There a port is the variable itself, and is read again in each tick. Here an input of a tree that
names a variable, and an output, are live as well; this module names what remains.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from bt_mission.base.diagnostics import Diagnostic
from bt_mission.language.expressions.expression import Expression
from bt_mission.language.mission import Mission, Tree
from bt_mission.language.nodes.base import NodeModel, Path
from bt_mission.language.nodes.composites import InTurnNode, ParallelNode
from bt_mission.language.nodes.decorators import RepeatNode, RetryNode
from bt_mission.language.nodes.subtree import TreeNode


@dataclass(frozen=True)
class LiveValue:
    """A value that would change: where it stands, why, and what to write instead."""

    tree: Tree
    path: Path
    message: str
    hint: str

    def diagnostic(self, code: str) -> Diagnostic:
        """Return it as an error."""
        return self.tree.document.diagnostic(code, self.path, self.message, self.hint)


def live_values(mission: Mission) -> Iterator[LiveValue]:
    """Yield the values of a mission that change there, and not here."""
    for tree in mission.all_trees:
        for node in tree.body.walk():
            if isinstance(node, TreeNode):
                yield from _shared(tree, node)
            elif isinstance(node, RepeatNode | RetryNode):
                yield from _count(mission, tree, node)


def _shared(tree: Tree, use: TreeNode) -> Iterator[LiveValue]:
    """Yield each variable that two ports of a subtree name, one of which writes it."""
    given = [
        (name, value.variable)
        for name, value in use.inputs.items()
        if isinstance(value, Expression)
    ]
    seen: dict[str, str] = {}
    for name, variable in use.outputs.items():
        others = [other for other, input_variable in given if input_variable == variable]
        other = seen.setdefault(variable, name)
        if other != name:
            others.append(other)
        for other in others:
            message = (
                f"'{other}' and '{name}' of the tree '{use.tree}' are the one variable "
                f"'{variable}': in BehaviorTree.CPP one changes with the other"
            )
            hint = "give one of them another variable"
            yield LiveValue(tree, (*use.path, "outputs", name), message, hint)


def _count(mission: Mission, tree: Tree, node: RepeatNode | RetryNode) -> Iterator[LiveValue]:
    """Yield the number of rounds, if it can change while they run."""
    key, what = ("count", "rounds") if isinstance(node, RepeatNode) else ("attempts", "attempts")
    value = getattr(node.settings, key)
    name = value.variable if isinstance(value, Expression) else None
    writer = None if name is None else _writer(mission, tree, node, name)
    if writer is not None:
        message = (
            f"the number of {what} '{name}' can change while the node runs, by the node in line "
            f"{writer.line}: BehaviorTree.CPP reads it in each tick, and a mission once"
        )
        hint = f"copy '{name}' to another variable before the node, and give that"
        yield LiveValue(tree, (*node.path, node.kind, key), message, hint)


def _writer(mission: Mission, tree: Tree, node: NodeModel, name: str) -> NodeModel | None:
    """Return a node that can write a variable of a tree while a node of it runs, or None."""
    for other in _meanwhile(tree.body, node):
        if any(write.variable == name for write in other.writes()):
            return other
    for caller in mission.all_trees if name in tree.types and not tree.is_main else ():
        for use in caller.body.walk():
            if isinstance(use, TreeNode) and use.tree == tree.name and name in use.live_inputs:
                writer = _writer(mission, caller, use, use.live_inputs[name])
                if writer is not None:
                    return writer
    return None


def _meanwhile(body: NodeModel, node: NodeModel) -> Iterator[NodeModel]:
    """Yield the nodes that can be ticked while a node runs: those below it, and beside it."""
    yield from node.walk()
    above = body
    while above is not node:
        index, inside = next(
            (index, child)
            for index, child in enumerate(above.below)
            if any(inner is node for inner in child.walk())
        )
        beside: tuple[NodeModel, ...] = ()
        if isinstance(above, ParallelNode):
            beside = (*above.below[:index], *above.below[index + 1 :])
        elif isinstance(above, InTurnNode) and not above.memory:
            beside = above.below[:index]
        for other in beside:
            yield from other.walk()
        above = inside
