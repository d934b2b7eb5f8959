"""A tree as shapes: boxes, lines and texts, which an SVG and a PNG are made of alike.

Families of nodes differ in colour, but in shape and sign, too.
"""

from __future__ import annotations

from dataclasses import dataclass

from bt_mission.language.nodes.base import Family
from bt_mission.views.drawing.layout import NodeBox, place
from bt_mission.views.drawing.letters import width_px, wrapped
from bt_mission.views.drawing.nodes import DrawnNode

COLOURS = {
    Family.COMPOSITE: ("#e4ebfa", "#3d5a99"),
    Family.DECORATOR: ("#fcefd2", "#a9781b"),
    Family.CONDITION: ("#efe3f7", "#7d4aa0"),
    Family.ACTION: ("#dff2e1", "#2f7d3b"),
    Family.MESSAGE: ("#dcf1f5", "#23788a"),
    Family.SUBTREE: ("#ffffff", "#444444"),
    Family.OTHER: ("#efefef", "#777777"),
}
"""Of a box: within, and around."""
INK = "#1c1c1c"
FAINT = "#555555"
PAPER = "#ffffff"
EDGE = "#8a8a8a"

FONT = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif"
NAME_PX = 13
DETAIL_PX = 11
LINE_PX = 15
PADDING_PX = 8
GAP_X_PX = 18
GAP_Y_PX = 30
MARGIN_PX = 16
WRAP_PX = 215
"""Details are wrapped at this width."""

MOST_DETAIL_LINES = 10
"""A goal with a long list would otherwise fill the page."""

INDENT = "\N{NO-BREAK SPACE}" * 3
"""The indent of a wrapped second line; SVG keeps no other blanks."""

SIGN_PX = 18
"""Side of the square that holds a node's sign."""


@dataclass(frozen=True)
class Rectangle:
    """A box with rounded corners, px."""

    x: float
    y: float
    width: float
    height: float
    radius: float
    fill: str
    stroke: str
    thick: float = 1.0


@dataclass(frozen=True)
class Polyline:
    """A line through points, px."""

    points: tuple[tuple[float, float], ...]
    stroke: str
    thick: float = 1.0


@dataclass(frozen=True)
class Words:
    """A text on one line; ``x`` is its left side, or its middle; ``y`` its baseline, px."""

    x: float
    y: float
    text: str
    size: float
    fill: str
    bold: bool = False
    centred: bool = False


Shape = Rectangle | Polyline | Words


@dataclass(frozen=True)
class Scene:
    """All shapes in the order in which they are drawn, and the size of the whole, px."""

    title: str
    width: float
    height: float
    shapes: tuple[Shape, ...]


class _NodeBox(NodeBox):
    """A node's box with its lines of text."""

    def __init__(self, node: DrawnNode) -> None:
        self.node = node
        self.details = _detail_lines(node)
        self.name = _cut(node.name)
        name = SIGN_PX + 6 + width_px(self.name, NAME_PX, bold=True)
        detail = max((width_px(line, DETAIL_PX) for line in self.details), default=0.0)
        width = max(name, detail) + 2 * PADDING_PX
        height = SIGN_PX + 2 * PADDING_PX + len(self.details) * LINE_PX
        super().__init__(width, height, [_NodeBox(child) for child in node.children])


def scene(root: DrawnNode, title: str) -> Scene:
    """Draw a tree."""
    top = _NodeBox(root)
    width, height = place(top, GAP_X_PX, GAP_Y_PX)
    head = list(wrapped(title, DETAIL_PX, max(width, 3 * WRAP_PX)))
    margin, below_head = MARGIN_PX, MARGIN_PX + len(head) * LINE_PX + 10
    shapes: list[Shape] = [
        Words(margin, margin + (i + 1) * LINE_PX - 4, line, DETAIL_PX, FAINT)
        for i, line in enumerate(head)
    ]
    boxes = list(top.walk())
    for box in boxes:
        box.x, box.y = box.x + margin, box.y + below_head
    for box in boxes:
        shapes += _edges(box)
    for box in boxes:
        assert isinstance(box, _NodeBox)
        shapes += _shapes(box)
    widest = max(width_px(line, DETAIL_PX) for line in head)
    return Scene(
        title, max(width, widest) + 2 * margin, height + below_head + margin, tuple(shapes)
    )


def _edges(box: NodeBox) -> list[Polyline]:
    edges = []
    for child in box.children:
        bend = child.y - GAP_Y_PX / 2
        down = ((box.middle, box.y + box.height), (box.middle, bend))
        across = ((child.middle, bend), (child.middle, child.y))
        edges.append(Polyline((*down, *across), EDGE, 1.2))
    return edges


def _shapes(box: _NodeBox) -> list[Shape]:
    family = box.node.sign.family
    fill, stroke = COLOURS[family]
    radius = box.height / 2 if family is Family.CONDITION and not box.details else 5.0
    pad = PADDING_PX
    shapes: list[Shape] = [Rectangle(box.x, box.y, box.width, box.height, radius, fill, stroke)]
    if family is Family.SUBTREE:
        shapes.append(
            Rectangle(box.x + 3, box.y + 3, box.width - 6, box.height - 6, 3.0, fill, stroke)
        )
    across = SIGN_PX + 6 + width_px(box.name, NAME_PX, bold=True)
    left = box.middle - across / 2 if not box.details else box.x + pad
    base, text = box.y + pad + SIGN_PX - 5, left + SIGN_PX + 6
    glyph = box.node.sign.glyph
    shapes += [
        Rectangle(left, box.y + pad, SIGN_PX, SIGN_PX, 4.0, stroke, stroke),
        Words(left + SIGN_PX / 2, base, glyph, NAME_PX, PAPER, bold=True, centred=True),
        Words(text, base, box.name, NAME_PX, INK, bold=True),
    ]
    first = box.y + pad + SIGN_PX + LINE_PX - 2
    shapes += [
        Words(box.x + pad, first + i * LINE_PX, line, DETAIL_PX, FAINT)
        for i, line in enumerate(box.details)
    ]
    return shapes


def _detail_lines(node: DrawnNode) -> list[str]:
    lines = [
        INDENT + line if index else line
        for detail in node.details
        for index, line in enumerate(wrapped(detail, DETAIL_PX, WRAP_PX))
    ]
    if len(lines) <= MOST_DETAIL_LINES:
        return lines
    kept = MOST_DETAIL_LINES - 1
    return [*lines[:kept], f"... {len(lines) - kept} more lines"]


def _cut(name: str) -> str:
    """A name that would be wider than two boxes is cut."""
    (first, *more) = list(wrapped(name, NAME_PX, 1.5 * WRAP_PX)) or [""]
    return f"{first}..." if more else first
