"""Nodes of the mission language to py_trees behaviours."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from py_trees.behaviour import Behaviour

from bt_mission.behaviours import control, decorators, leaves
from bt_mission.behaviours.action_leaf import ActionLeaf
from bt_mission.behaviours.cleanup import Finally
from bt_mission.behaviours.decorators import Subtree
from bt_mission.behaviours.evaluator import BuildContext, Evaluator
from bt_mission.behaviours.hooks import (
    FailureIsSuccess,
    Inverter,
    Selector,
    Sequence,
    SuccessIsFailure,
)
from bt_mission.behaviours.python_leaf import PythonLeaf
from bt_mission.behaviours.runtime import Scope
from bt_mission.behaviours.service_leaf import ServiceLeaf
from bt_mission.behaviours.topic_leaves import PublishLeaf, WaitFor
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.base import NodeModel
from bt_mission.language.nodes.decorators import ForceNode
from bt_mission.language.nodes.fields import LIMIT
from bt_mission.language.nodes.subtree import TreeNode


def build_tree(mission: Mission, scope: Scope) -> Behaviour:
    """Return the tree of a mission; its leaves read and write `scope`.

    The scope takes note of what follows a topic.

    Nothing of ROS is needed to build it. Give each node its `setup(runtime=...)` before the first
    tick.
    """
    scope.followed = mission.follow
    return _build(Evaluator(mission.root, "0", BuildContext(mission, mission.file, scope)))


def revise_tree(mission: Mission, scope: Scope) -> None:
    """Have the nodes of a tree that was built go by another version of its mission from now on.

    A node that runs keeps what it has read when it began.

    Args:
        mission: Each of its nodes has the frame of the one before.
        scope: With which the tree was built.
    """
    waiting: list[tuple[str, NodeModel, str]] = [("0", mission.root, mission.file)]
    while waiting:
        path, node, file = waiting.pop()
        scope.evaluators[path].revise(node, file)
        below = [(one, file) for one in node.below]
        if isinstance(node, TreeNode):
            tree = mission.trees[node.tree]
            below = [(tree.body, tree.document.file)]
        waiting += [(f"{path}.{index}", *one) for index, one in enumerate(below)]


def node_details(mission: Mission) -> dict[str, tuple[str, ...]]:
    """Return what each node is asked to do, in its author's words, by its path; none for some."""
    found: dict[str, tuple[str, ...]] = {}
    waiting: list[tuple[str, NodeModel]] = [("0", mission.tree)]
    while waiting:
        path, node = waiting.pop()
        if lines := node.details():
            found[path] = tuple(lines)
        below = (mission.trees[node.tree].body,) if isinstance(node, TreeNode) else node.below
        waiting += [(f"{path}.{index}", one) for index, one in enumerate(below)]
    return found


def _build(values: Evaluator) -> Behaviour:
    below = [
        _build(Evaluator(node, f"{values.path}.{index}", values.context))
        for index, node in enumerate(values.node.below)
    ]
    return BEHAVIOURS[values.node.kind](values.node, values, below)


def _subtree(node: TreeNode, values: Evaluator, _below: list[Behaviour]) -> Subtree:
    mission, outer = values.context.mission, values.context.scope
    tree = mission.trees[node.tree]
    inner = outer.inner(tree.follow)
    context = BuildContext(mission, tree.document.file, inner)
    body = _build(Evaluator(tree.body, f"{values.path}.0", context))

    def inputs() -> dict[str, Any]:
        return {**tree.inputs, **values.inputs(values.node.inputs, values.node.takes)}

    return Subtree(node.label, body, inputs, inner, outer, node.outputs)


def _force(node: ForceNode, _values: Evaluator, below: list[Behaviour]) -> Behaviour:
    kind = FailureIsSuccess if node.status == "success" else SuccessIsFailure
    return kind(node.label, below[0])


BEHAVIOURS: dict[str, Callable[[Any, Evaluator, list[Behaviour]], Behaviour]] = {
    "sequence": lambda node, _, below: Sequence(node.label, node.memory, below),
    "fallback": lambda node, _, below: Selector(node.label, node.memory, below),
    "parallel": lambda node, _, below: control.Parallel(
        node.label,
        below,
        node.needed,
        fail_fast=node.fail_when == "any",
        finish=node.rest == "finish",
    ),
    "choose": lambda node, values, below: control.Pick(node.label, below, values.lot(len(below))),
    "when": lambda node, values, below: control.Pick(
        node.label, below, values.fork(lambda: values.node.condition)
    ),
    "repeat": lambda node, values, below: decorators.Repeat(node.label, below[0], values.rounds()),
    "retry": lambda node, values, below: decorators.Retry(
        node.label,
        below[0],
        values.times(lambda: values.node.settings.attempts),
        values.seconds(lambda: values.node.settings.pause),
    ),
    "timeout": lambda node, values, below: control.Timeout(
        node.label, below[0], lambda: values.number(values.node.seconds, LIMIT)
    ),
    "invert": lambda node, _, below: Inverter(node.label, below[0]),
    "force": _force,
    "guard": lambda node, values, below: control.Guard(
        node.label, below[0], values.question(lambda: values.node.condition)
    ),
    "for_each": lambda node, values, below: control.ForEach(
        node.label,
        below[0],
        lambda: values.elements(values.node.elements),
        *values.loop(node.variable),
    ),
    "finally": lambda node, values, below: Finally(
        node.label,
        below,
        lambda: values.number(values.node.settings.timeout, LIMIT),
        values.context.scope,
    ),
    "check": lambda node, values, _: leaves.Check(
        node.label, values.question(lambda: values.node.condition)
    ),
    "set": lambda node, values, _: leaves.Set(
        node.label, lambda: values.assign(values.node.values)
    ),
    "wait": lambda node, values, _: leaves.Wait(
        node.label, values.seconds(lambda: values.node.seconds)
    ),
    "log": lambda node, values, _: leaves.Log(
        node.label, lambda: str(values.resolve(values.node.message))
    ),
    "action": lambda node, values, _: ActionLeaf(node, values),
    "service": lambda node, values, _: ServiceLeaf(node, values),
    "wait_for": lambda node, values, _: WaitFor(node, values),
    "publish": lambda node, values, _: PublishLeaf(node, values),
    "tree": _subtree,
    "python": lambda node, values, _: PythonLeaf(node, values),
}
"""How a node of each kind is built, with what computes its values, and the behaviours below it."""
