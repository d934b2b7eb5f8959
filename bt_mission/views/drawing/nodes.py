"""What a drawing shows of a mission: its nodes, with what they do in a few words."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from bt_mission.language.expressions.expression import written_text
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.base import NodeModel
from bt_mission.language.nodes.subtree import TreeNode


class Family(StrEnum):
    """What belongs together looks alike."""

    COMPOSITE = "composite"
    DECORATOR = "decorator"
    CONDITION = "condition"
    ACTION = "action"
    MESSAGE = "message"
    SUBTREE = "subtree"
    OTHER = "other"


@dataclass(frozen=True)
class Sign:
    """How a kind of node is marked, without colour: a glyph, its form in ASCII, and in words."""

    glyph: str
    ascii: str
    words: str
    family: Family


SIGNS: dict[str, Sign] = {
    "sequence": Sign("→", "->", "sequence", Family.COMPOSITE),
    "fallback": Sign("?", "?", "fallback", Family.COMPOSITE),
    "parallel": Sign("⇉", "=>", "parallel", Family.COMPOSITE),
    "choose": Sign("⚄", "%", "choice", Family.COMPOSITE),
    "when": Sign("◇", "<>", "when", Family.CONDITION),
    "repeat": Sign("↻", "@", "repeat", Family.DECORATOR),
    "for_each": Sign("∀", "@", "for each", Family.DECORATOR),
    "retry": Sign("↺", "@", "retry", Family.DECORATOR),
    "timeout": Sign("◷", "t", "timeout", Family.DECORATOR),
    "invert": Sign("≠", "!", "invert", Family.DECORATOR),
    "force": Sign("=", "=", "force", Family.DECORATOR),
    "guard": Sign("◈", "<>", "guard", Family.CONDITION),
    "check": Sign("◇", "<>", "check", Family.CONDITION),
    "set": Sign("≔", ":=", "set", Family.OTHER),
    "wait": Sign("◷", "t", "wait", Family.OTHER),
    "log": Sign("¶", '"', "log", Family.OTHER),
    "publish": Sign("◁", "<|", "publish", Family.MESSAGE),
    "wait_for": Sign("▷", "|>", "wait for a message", Family.MESSAGE),
    "service": Sign("⇄", "<>", "service", Family.ACTION),
    "action": Sign("▶", ">", "action", Family.ACTION),
    "tree": Sign("▣", "[]", "tree", Family.SUBTREE),
    "python": Sign("λ", "py", "python", Family.OTHER),
}


@dataclass(frozen=True)
class DrawnNode:
    """One node of a drawing.

    Args:
        name: As the tree calls it when it runs.
        details: What it does, in order of importance.
    """

    kind: str
    name: str
    details: tuple[str, ...]
    children: tuple[DrawnNode, ...]

    @property
    def sign(self) -> Sign:
        """How it is marked."""
        return SIGNS[self.kind]


def drawn(mission: Mission) -> DrawnNode:
    """The tree of a mission, with the trees that it uses in their places."""
    root = _node(mission.tree, mission)
    named = not mission.tree.name and bool(mission.tree.below)
    return DrawnNode(root.kind, mission.name, root.details, root.children) if named else root


def heading(mission: Mission) -> str:
    """What the mission is, in one line."""
    where = f" in {mission.world}" if mission.world else ""
    inputs = ", ".join(f"{name} {written_text(value)}" for name, value in mission.inputs.items())
    return f"{mission.name}{where} ({mission.robot})" + (f"; {inputs}" if inputs else "")


def _node(node: NodeModel, mission: Mission) -> DrawnNode:
    below = (mission.trees[node.tree].body,) if isinstance(node, TreeNode) else node.below
    children = tuple(_node(child, mission) for child in below)
    return DrawnNode(node.kind, node.label, tuple(node.details()), children)
