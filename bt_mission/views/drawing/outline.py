"""A tree as text: a line for each node, with signs that read without colour."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from bt_mission.views.drawing.nodes import SIGNS, DrawnNode, Family


@dataclass(frozen=True)
class OutlineRow:
    """A line of the outline in its parts, so that each can have its own colour."""

    branches: str
    sign: str
    name: str
    details: str
    family: Family

    def __str__(self) -> str:
        details = f"  {self.details}" if self.details else ""
        return f"{self.branches}{self.sign} {self.name}{details}"


@dataclass(frozen=True)
class Lines:
    """The signs that a tree's branches are made of."""

    last: str
    more: str
    on: str
    gap: str


UNICODE = Lines("└─ ", "├─ ", "│  ", "   ")
ASCII = Lines("`- ", "|- ", "|  ", "   ")


def outline(root: DrawnNode, *, ascii_only: bool = False) -> Iterator[OutlineRow]:
    """The rows of a tree, from the root down."""
    lines = ASCII if ascii_only else UNICODE
    waiting: list[tuple[DrawnNode, str, str]] = [(root, "", "")]
    while waiting:
        node, branches, below = waiting.pop()
        sign = node.sign.ascii if ascii_only else node.sign.glyph
        yield OutlineRow(branches, sign, node.name, "; ".join(node.details), node.sign.family)
        children = [(child, lines.more, lines.on) for child in node.children]
        if children:
            children[-1] = (node.children[-1], lines.last, lines.gap)
        waiting += [(child, below + branch, below + on) for child, branch, on in reversed(children)]


def legend(root: DrawnNode, *, ascii_only: bool = False) -> str:
    """What the signs that occur stand for, each once."""
    found: dict[str, str] = {}
    waiting = [root]
    while waiting:
        node = waiting.pop()
        sign = node.sign.ascii if ascii_only else node.sign.glyph
        words = found.setdefault(sign, node.sign.words)
        if node.sign.words not in words.split(" or "):
            found[sign] = f"{words} or {node.sign.words}"
        waiting += reversed(node.children)
    return "   ".join(f"{sign} {words}" for sign, words in found.items())


def can_show(encoding: str | None) -> bool:
    """Has a stream of this encoding all the signs?"""
    signs = "".join(sign.glyph for sign in SIGNS.values())
    try:
        (signs + UNICODE.last + UNICODE.more + UNICODE.on).encode(encoding or "ascii")
    except (UnicodeEncodeError, LookupError):
        return False
    return True
