"""Nodes of the mission language to py_trees behaviours."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any, TypeAlias

from py_trees.behaviour import Behaviour

from bt_mission.executive.behaviours import cleanup, control, decorators, leaves
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.behaviours.client_leaves import PublishLeaf, ServiceLeaf, WaitFor
from bt_mission.executive.behaviours.evaluator import Evaluator
from bt_mission.executive.behaviours.python_leaf import PythonLeaf
from bt_mission.executive.behaviours.runtime import Scope
from bt_mission.language.mission import Mission
from bt_mission.language.nodes import composites, interfaces
from bt_mission.language.nodes import decorators as decorated
from bt_mission.language.nodes import leaves as written
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.nodes.base import NodeModel
from bt_mission.language.nodes.subtree import TreeNode

BEHAVIOURS: dict[type[NodeModel], Callable[[Any, Evaluator], Behaviour]] = {
    composites.SequenceNode: control.Sequence,
    composites.FallbackNode: control.Selector,
    composites.ParallelNode: control.Parallel,
    composites.ChooseNode: control.Choose,
    composites.WhenNode: control.When,
    composites.FinallyNode: cleanup.Finally,
    decorated.RepeatNode: decorators.Repeat,
    decorated.RetryNode: decorators.Retry,
    decorated.TimeoutNode: control.Timeout,
    decorated.InvertNode: decorators.Inverter,
    decorated.ForceNode: decorators.Force,
    decorated.GuardNode: control.Guard,
    decorated.ForEachNode: control.ForEach,
    written.CheckNode: leaves.Check,
    written.SetNode: leaves.Set,
    written.WaitNode: leaves.Wait,
    written.LogNode: leaves.Log,
    written.PythonNode: PythonLeaf,
    GoalNode: ActionLeaf,
    interfaces.ServiceNode: ServiceLeaf,
    interfaces.WaitForNode: WaitFor,
    interfaces.PublishNode: PublishLeaf,
    TreeNode: decorators.Subtree,
}
"""The behaviour of each kind of node, built from the node and the evaluator of its values."""


Behaviours: TypeAlias = Mapping[type[NodeModel], Callable[[Any, Evaluator], Behaviour]]


def build_tree(
    mission: Mission, scope: Scope, behaviours: Behaviours = MappingProxyType(BEHAVIOURS)
) -> Behaviour:
    """Return the tree of a mission; its leaves read and write `scope`.

    The scope notes which variables follow a topic. Building a tree needs no ROS. Call each node's
    `setup(runtime=...)` before the first tick.

    Args:
        behaviours: The behaviour of each kind of node.
    """
    scope.followed = mission.follow
    return _built(mission.root, "0", mission, mission.file, scope, behaviours)


def revise_tree(mission: Mission, scope: Scope) -> None:
    """Replace the mission of a tree that is already built by another version of it.

    A running node keeps what it read when it started.

    Args:
        mission: Each of its nodes has the frame of the earlier one.
        scope: The scope with which the tree was built.
    """
    for path, node, file in _nodes(mission):
        scope.evaluators[path].revise(node, file)


def node_details(mission: Mission) -> Mapping[str, tuple[str, ...]]:
    """Return the details of each node that has any, as its author wrote them, by path."""
    details = {path: tuple(node.details()) for path, node, _ in _nodes(mission)}
    return {path: lines for path, lines in details.items() if lines}


def _nodes(mission: Mission) -> Iterator[tuple[str, NodeModel, str]]:
    """Yield each node of a tree as it is built, with its path and its file."""
    waiting: list[tuple[str, NodeModel, str]] = [("0", mission.root, mission.file)]
    while waiting:
        path, node, file = waiting.pop()
        yield path, node, file
        file = mission.trees[node.tree].document.file if isinstance(node, TreeNode) else file
        below = enumerate(mission.below(node))
        waiting += [(f"{path}.{index}", child, file) for index, child in below]


def _built(
    node: NodeModel, path: str, mission: Mission, file: str, scope: Scope, behaviours: Behaviours
) -> Behaviour:
    values = Evaluator(node, path, mission, file, scope)
    if isinstance(node, TreeNode):
        tree = mission.trees[node.tree]
        file, values.inner = tree.document.file, scope.inner(tree.follow)
    values.children = [
        _built(child, f"{path}.{index}", mission, file, values.inner, behaviours)
        for index, child in enumerate(mission.below(node))
    ]
    kind = next(kind for kind in type(node).__mro__ if kind in behaviours)
    return behaviours[kind](node, values)
