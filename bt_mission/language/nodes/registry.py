"""Every kind of node of the mission language."""

from __future__ import annotations

from bt_mission.language.nodes import composites, decorators, leaves
from bt_mission.language.nodes.action import SHORT_NODES, ActionNode
from bt_mission.language.nodes.base import NodeModel
from bt_mission.language.nodes.interfaces import PublishNode, ServiceNode, WaitForNode
from bt_mission.language.nodes.leaves import PythonNode
from bt_mission.language.nodes.subtree import TreeNode

_NODES: tuple[type[NodeModel], ...] = (
    composites.SequenceNode,
    composites.FallbackNode,
    composites.ParallelNode,
    decorators.RepeatNode,
    decorators.RetryNode,
    composites.ChooseNode,
    decorators.TimeoutNode,
    decorators.InvertNode,
    decorators.ForceNode,
    decorators.GuardNode,
    composites.WhenNode,
    composites.FinallyNode,
    decorators.ForEachNode,
    leaves.CheckNode,
    leaves.SetNode,
    leaves.WaitNode,
    leaves.LogNode,
    ActionNode,
    ServiceNode,
    WaitForNode,
    PublishNode,
    TreeNode,
    PythonNode,
)

KINDS: dict[str, type[NodeModel]] = {node.kind: node for node in _NODES}
KINDS |= {name: node for name, node in SHORT_NODES.items() if name not in KINDS}
"""Every kind of node by the key that names it, in the order in which they are listed."""
