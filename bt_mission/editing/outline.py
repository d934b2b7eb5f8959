"""The nodes of a mission as a drawing shows them, also of one with errors."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from bt_mission.core.text import escape_control
from bt_mission.editing.source import CHILD_KEYS, LIST_KEYS
from bt_mission.editing.spans import Path, Span
from bt_mission.language.nodes.base import Family
from bt_mission.language.nodes.registry import KINDS

MOST_TEXT = 60
"""Characters of a value that a box shows."""

UNKNOWN = "?"
"""The kind of a mapping in the place of a node that names no kind."""


@dataclass(frozen=True)
class Box:
    """A node of a drawing.

    Attributes:
        path: The keys and indices that lead to it.
        parent: The index of the box above it, or -1.
        start: The offset of its first character; `end` is behind its last one.
        detail: The value of its kind, on one line.
        is_empty: Whether it is a place for a node that is not written yet.
    """

    path: Path
    parent: int
    kind: str
    name: str
    detail: str
    start: int
    end: int
    is_empty: bool = False

    def as_row(self) -> dict[str, Any]:
        """Return it for a page."""
        model = KINDS.get(self.kind)
        return {
            "path": list(self.path),
            "parent": self.parent,
            "kind": escape_control(self.kind),
            "name": escape_control(self.name),
            "detail": escape_control(self.detail),
            "family": (model.sign.family if model else Family.OTHER).value,
            "glyph": model.sign.glyph if model else UNKNOWN,
            "start": self.start,
            "end": self.end,
            "is_empty": self.is_empty,
            "takes_list": self.kind in LIST_KEYS,
        }


def outline(root: Span, text: str) -> list[Box]:
    """Return the boxes of a mission: its tree, then its named trees, each with its nodes below."""
    boxes: list[Box] = []
    tree = root.parts.get("tree")
    if tree is not None:
        _take(boxes, tree, ("tree",), -1, text)
    trees = root.parts.get("trees")
    for name, definition in (trees.parts if trees else {}).items():
        path: Path = ("trees", name)
        boxes.append(Box(path, -1, "trees", name, "", definition.start, definition.end))
        body = definition.parts.get("do")
        if body is not None:
            _take(boxes, body, (*path, "do"), len(boxes) - 1, text)
    return boxes


def kind_of(node: Span) -> str:
    """Return the kind that a written node names; `UNKNOWN` without one."""
    kinds = [key for key in node.parts if key in KINDS]
    if len(kinds) > 1 and "timeout" in kinds:
        kinds.remove("timeout")
    return kinds[0] if kinds else UNKNOWN


def _take(boxes: list[Box], node: Span, path: Path, parent: int, text: str) -> None:
    waiting = [(node, path, parent)]
    while waiting:
        node, path, parent = waiting.pop()
        index = len(boxes)
        if node.kind != "map":
            shown = "" if node.is_empty else _on_one_line(node, text)
            kind = "" if node.is_empty else UNKNOWN
            place = (node.start, node.end, node.is_empty)
            boxes.append(Box(path, parent, kind, "", shown, *place))
            continue
        kind = kind_of(node)
        name = node.parts["name"].text if "name" in node.parts else ""
        value = node.parts.get(kind)
        detail = "" if value is None or kind in LIST_KEYS else _on_one_line(value, text)
        detail = "" if kind == "invert" else detail
        boxes.append(Box(path, parent, kind, name, detail, node.start, node.end))
        below = [(child, (*path, *rest), index) for child, rest in _places(node, kind)]
        waiting.extend(reversed(below))


def _places(node: Span, kind: str) -> Iterator[tuple[Span, Path]]:
    """Yield what is in the places for nodes directly below a node, empty places included."""
    if kind in LIST_KEYS:
        yield from ((item, (kind, index)) for index, item in enumerate(node.parts[kind].items))
        return
    wanted = KINDS[kind].child_keys if kind in KINDS else CHILD_KEYS
    for key in wanted:
        part = node.parts.get(key)
        if part is not None:
            yield part, (key,)
        elif key == "do":
            yield Span(node.end, node.end, "scalar"), (key,)


def _on_one_line(value: Span, text: str) -> str:
    written = text[value.start : value.end]
    if value.kind == "map" and not value.is_flow:
        pairs = (f"{key}: {_on_one_line(part, text)}" for key, part in value.parts.items())
        written = ", ".join(pairs)
    elif value.kind == "map":
        written = written.strip("{}")
    elif value.kind == "scalar":
        written = value.text
    written = " ".join(written.split())
    return written if len(written) <= MOST_TEXT else written[: MOST_TEXT - 1] + "…"
