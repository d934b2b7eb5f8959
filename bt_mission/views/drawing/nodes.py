"""The content of a drawing: the nodes of a mission with short details; also as text."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from bt_mission.base.text import can_encode, escape_control
from bt_mission.language.expressions.expression import written_text
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.base import Family, NodeModel, Sign
from bt_mission.language.nodes.registry import GENERAL


@dataclass(frozen=True)
class DrawnNode:
    """One node of a drawing.

    Args:
        name: Its name when the tree runs.
        details: What it does, the most important first.
    """

    kind: str
    name: str
    details: tuple[str, ...]
    children: tuple[DrawnNode, ...]
    sign: Sign


def drawn(mission: Mission) -> DrawnNode:
    """The tree of a mission, with the trees that it uses in their places."""
    return _node(mission.root, mission)


def heading(mission: Mission) -> str:
    """The mission, in one line."""
    where = f" in {mission.world}" if mission.world else ""
    inputs = ", ".join(f"{name} {written_text(value)}" for name, value in mission.inputs.items())
    words = f"{mission.name}{where} ({mission.robot})" + (f"; {inputs}" if inputs else "")
    return escape_control(words)


def _node(node: NodeModel, mission: Mission) -> DrawnNode:
    children = tuple(_node(child, mission) for child in mission.below(node))
    return DrawnNode(node.kind, node.label, tuple(node.details()), children, node.sign)


@dataclass(frozen=True)
class OutlineRow:
    """A line of the outline in parts, so that each can have a colour."""

    branches: str
    sign: str
    name: str
    details: str
    family: Family

    def __str__(self) -> str:
        details = f"  {self.details}" if self.details else ""
        return f"{self.branches}{self.sign} {self.name}{details}"


BRANCHES = {False: ("└─ ", "├─ ", "│  "), True: ("`- ", "|- ", "|  ")}
"""The branches to the last child, to others, and below others; by whether in ASCII."""


def outline(root: DrawnNode, *, ascii_only: bool = False) -> Iterator[OutlineRow]:
    """The rows of a tree, from the root down, with names and details escaped."""
    last, more, on = BRANCHES[ascii_only]
    waiting: list[tuple[DrawnNode, str, str]] = [(root, "", "")]
    while waiting:
        node, branches, below = waiting.pop()
        sign = node.sign.ascii if ascii_only else node.sign.glyph
        name, details = escape_control(node.name), escape_control("; ".join(node.details))
        yield OutlineRow(branches, sign, name, details, node.sign.family)
        children = [(child, more, on) for child in node.children]
        if children:
            children[-1] = (node.children[-1], last, "   ")
        waiting += [
            (child, below + branch, below + beside) for child, branch, beside in reversed(children)
        ]


def legend(root: DrawnNode, *, ascii_only: bool = False) -> str:
    """Return the meaning of the signs that occur, each once."""
    signs: dict[str, str] = {}
    waiting = [root]
    while waiting:
        node = waiting.pop()
        sign = node.sign.ascii if ascii_only else node.sign.glyph
        words = signs.setdefault(sign, node.sign.words)
        if node.sign.words not in words.split(" or "):
            signs[sign] = f"{words} or {node.sign.words}"
        waiting += reversed(node.children)
    return "   ".join(f"{sign} {words}" for sign, words in signs.items())


def can_show(encoding: str | None) -> bool:
    """Return whether a stream of this encoding has all the signs."""
    signs = [node.sign.glyph for node in GENERAL.values()]
    return can_encode("".join((*signs, *BRANCHES[False])), encoding)
