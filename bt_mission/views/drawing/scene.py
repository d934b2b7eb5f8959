"""A tree as shapes: boxes, lines and texts, which an SVG and a PNG are made of alike."""

from __future__ import annotations

from dataclasses import dataclass

from bt_mission.views.drawing import style
from bt_mission.views.drawing.layout import NodeBox, place
from bt_mission.views.drawing.letters import width_px, wrapped
from bt_mission.views.drawing.nodes import DrawnNode, Family

INDENT = "\N{NO-BREAK SPACE}" * 3
"""Before the second line of what is wrapped; SVG keeps no other blanks."""

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
        name = SIGN_PX + 6 + width_px(self.name, style.NAME_PX, bold=True)
        detail = max((width_px(line, style.DETAIL_PX) for line in self.details), default=0.0)
        width = max(name, detail) + 2 * style.PADDING_PX
        height = SIGN_PX + 2 * style.PADDING_PX + len(self.details) * style.LINE_PX
        super().__init__(width, height, [_NodeBox(child) for child in node.children])


def scene(root: DrawnNode, title: str) -> Scene:
    """Draw a tree."""
    top = _NodeBox(root)
    width, height = place(top, style.GAP_X_PX, style.GAP_Y_PX)
    head = list(wrapped(title, style.DETAIL_PX, max(width, 3 * style.WRAP_PX)))
    margin, below_head = style.MARGIN_PX, style.MARGIN_PX + len(head) * style.LINE_PX + 10
    shapes: list[Shape] = [
        Words(margin, margin + (i + 1) * style.LINE_PX - 4, line, style.DETAIL_PX, style.FAINT)
        for i, line in enumerate(head)
    ]
    boxes = []
    waiting: list[NodeBox] = [top]
    while waiting:
        box = waiting.pop()
        box.x, box.y = box.x + margin, box.y + below_head
        boxes.append(box)
        waiting += reversed(box.children)
    for box in boxes:
        shapes += _edges(box)
    for box in boxes:
        assert isinstance(box, _NodeBox)
        shapes += _shapes(box)
    widest = max(width_px(line, style.DETAIL_PX) for line in head)
    return Scene(
        title, max(width, widest) + 2 * margin, height + below_head + margin, tuple(shapes)
    )


def _edges(box: NodeBox) -> list[Polyline]:
    found = []
    for child in box.children:
        bend = child.y - style.GAP_Y_PX / 2
        down = ((box.middle, box.y + box.height), (box.middle, bend))
        across = ((child.middle, bend), (child.middle, child.y))
        found.append(Polyline((*down, *across), style.EDGE, 1.2))
    return found


def _shapes(box: _NodeBox) -> list[Shape]:
    family = box.node.sign.family
    fill, stroke = style.FILLS[family], style.STROKES[family]
    radius = box.height / 2 if family is Family.CONDITION and not box.details else 5.0
    pad = style.PADDING_PX
    shapes: list[Shape] = [Rectangle(box.x, box.y, box.width, box.height, radius, fill, stroke)]
    if family is Family.SUBTREE:
        shapes.append(
            Rectangle(box.x + 3, box.y + 3, box.width - 6, box.height - 6, 3.0, fill, stroke)
        )
    across = SIGN_PX + 6 + width_px(box.name, style.NAME_PX, bold=True)
    left = box.middle - across / 2 if not box.details else box.x + pad
    sign = Rectangle(left, box.y + pad, SIGN_PX, SIGN_PX, 4.0, stroke, stroke)
    base = box.y + pad + SIGN_PX - 5
    shapes += [
        sign,
        Words(
            left + SIGN_PX / 2,
            base,
            box.node.sign.glyph,
            style.NAME_PX,
            style.PAPER,
            bold=True,
            centred=True,
        ),
        Words(left + SIGN_PX + 6, base, box.name, style.NAME_PX, style.INK, bold=True),
    ]
    shapes += [
        Words(
            box.x + pad,
            box.y + pad + SIGN_PX + (i + 1) * style.LINE_PX - 2,
            line,
            style.DETAIL_PX,
            style.FAINT,
        )
        for i, line in enumerate(box.details)
    ]
    return shapes


def _detail_lines(node: DrawnNode) -> list[str]:
    lines = [
        INDENT + line if index else line
        for detail in node.details
        for index, line in enumerate(wrapped(detail, style.DETAIL_PX, style.WRAP_PX))
    ]
    if len(lines) <= style.MOST_DETAIL_LINES:
        return lines
    kept = style.MOST_DETAIL_LINES - 1
    return [*lines[:kept], f"... {len(lines) - kept} more lines"]


def _cut(name: str) -> str:
    """A name that would be wider than two boxes is cut."""
    (first, *more) = list(wrapped(name, style.NAME_PX, 1.5 * style.WRAP_PX)) or [""]
    return f"{first}..." if more else first
