"""Missions compared by what they mean, wherever they stand in their files."""

from __future__ import annotations

from typing import Any

from bt_mission.language.mission import Mission
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.nodes.base import NodeModel

STRUCTURE = {"place", "child", "children", "otherwise"}
GOAL = {"settings", "goal"}


def bare(node: NodeModel) -> Any:
    """A node and all below it as plain data, without places."""
    left_out = STRUCTURE | (GOAL if isinstance(node, GoalNode) else set())
    names = type(node).model_fields.keys() - left_out
    own = {name: getattr(node, name) for name in names}
    if isinstance(node, GoalNode):
        own |= {"action": node.ros_name, "type": node.type, "goal": node.sent}
    return node.kind, own, [bare(child) for child in node.below]


def meaning(mission: Mission) -> Any:
    """Everything of a mission but where it stands, and what is a warning."""
    trees = {
        name: (bare(tree.body), tree.inputs, tree.types, tree.outputs, tree.lost)
        for name, tree in mission.trees.items()
    }
    head = (mission.name, mission.description, mission.world, mission.robot, mission.seed)
    return head, mission.map, mission.inputs, mission.lost, trees, bare(mission.tree)
