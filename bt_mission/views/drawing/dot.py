"""A tree in the language of Graphviz."""

from __future__ import annotations

from collections.abc import Iterator

from bt_mission.base.text import escape_lines
from bt_mission.language.nodes.base import Family
from bt_mission.views.drawing.nodes import DrawnNode
from bt_mission.views.drawing.scene import COLOURS

SHAPES = {Family.CONDITION: "ellipse", Family.SUBTREE: "component"}


def dot(root: DrawnNode, title: str) -> str:
    """Return the whole graph; ``dot -Tpdf`` makes a page of it."""
    return "\n".join(_lines(root, title)) + "\n"


def _lines(root: DrawnNode, title: str) -> Iterator[str]:
    yield "digraph mission {"
    yield f'  label={_quoted(title)}; labelloc=t; fontname="sans-serif";'
    yield '  node [fontname="sans-serif", fontsize=10, shape=box, style="filled,rounded"];'
    yield "  edge [arrowhead=none]; ordering=out;"
    waiting: list[tuple[DrawnNode, str, str | None]] = [(root, "n", None)]
    while waiting:
        node, name, above = waiting.pop()
        label = "\n".join((f"{node.sign.glyph} {node.name}", *node.details))
        shape = SHAPES.get(node.sign.family, "box")
        fill, _ = COLOURS[node.sign.family]
        yield f'  {name} [label={_quoted(label)}, shape={shape}, fillcolor="{fill}"];'
        if above is not None:
            yield f"  {above} -> {name};"
        below = [(child, f"{name}_{index}", name) for index, child in enumerate(node.children)]
        waiting += reversed(below)
    yield "}"


def _quoted(text: str) -> str:
    escaped = escape_lines(text).replace("&", "&amp;").replace("\\", "\\\\")
    escaped = escaped.replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'
