"""The nodes of a mission as a drawing shows them, also of one with errors."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_mission.base.text import escape_control
from bt_mission.commands.edit.source import CHILD_KEYS, LIST_KEYS
from bt_mission.commands.edit.spans import Path, TextSpan
from bt_mission.language.nodes.base import Family
from bt_mission.language.nodes.registry import KINDS

MOST_TEXT = 60
"""Characters of a value that a box shows."""

MISSION, NAMED_TREE = "mission", "named tree"
"""The kinds of the boxes around nodes."""

GLYPHS = {MISSION: "◎", NAMED_TREE: "▣"}

UNKNOWN = "?"
"""The kind of a mapping in the place of a node that names no kind."""


@dataclass(frozen=True)
class OutlineBox:
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
    values: Mapping[str, str] = field(default_factory=dict)
    """The written values of its fields, by their keys with dots between them."""

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
            "glyph": model.sign.glyph if model else GLYPHS.get(self.kind, UNKNOWN),
            "start": self.start,
            "end": self.end,
            "is_empty": self.is_empty,
            "takes_list": self.kind in LIST_KEYS,
            "values": dict(self.values),
        }


def outline(root: TextSpan, text: str) -> list[OutlineBox]:
    """Return the boxes of a mission: itself, its tree, then its named trees."""
    boxes: list[OutlineBox] = []
    if root.kind != "map":
        return boxes
    names = {key: root.parts[key].text for key in ("mission", "world") if key in root.parts}
    values = dict(_values(root, ("tree", "trees"), text))
    name, detail = names.get("mission", ""), names.get("world", "")
    boxes.append(OutlineBox((), -1, MISSION, name, detail, root.start, root.end, values=values))
    tree = root.parts.get("tree")
    if tree is not None:
        _take(boxes, tree, ("tree",), 0, text)
    trees = root.parts.get("trees")
    for name, definition in (trees.parts if trees else {}).items():
        path: Path = ("trees", name)
        boxes.append(OutlineBox(path, 0, NAMED_TREE, name, "", definition.start, definition.end))
        body = definition.parts.get("do")
        if body is not None:
            _take(boxes, body, (*path, "do"), len(boxes) - 1, text)
    return boxes


def _values(node: TextSpan, left_out: Collection[str], text: str) -> Iterator[tuple[str, str]]:
    """Yield what is written in the fields of a node, and in the fields of those."""
    for key, part in node.parts.items():
        if key in left_out:
            continue
        if part.kind == "map":
            for inner, value in part.parts.items():
                yield f"{key}.{inner}", _written(value, text)
        else:
            yield key, _written(part, text)


def kind_of(node: TextSpan) -> str:
    """Return the kind that a written node names; `UNKNOWN` without one."""
    kinds = [key for key in node.parts if key in KINDS]
    if len(kinds) > 1 and "timeout" in kinds:
        kinds.remove("timeout")
    return kinds[0] if kinds else UNKNOWN


def _take(boxes: list[OutlineBox], node: TextSpan, path: Path, parent: int, text: str) -> None:
    waiting = [(node, path, parent)]
    while waiting:
        node, path, parent = waiting.pop()
        index = len(boxes)
        if node.kind != "map":
            shown = "" if node.is_empty else _on_one_line(node, text)
            kind = "" if node.is_empty else UNKNOWN
            place = (node.start, node.end, node.is_empty)
            boxes.append(OutlineBox(path, parent, kind, "", shown, *place))
            continue
        kind = kind_of(node)
        name = node.parts["name"].text if "name" in node.parts else ""
        value = node.parts.get(kind)
        detail = "" if value is None or kind in LIST_KEYS else _on_one_line(value, text)
        detail = "" if kind == "invert" else detail
        left_out = (*LIST_KEYS, *CHILD_KEYS)
        values = dict(_values(node, left_out, text))
        boxes.append(
            OutlineBox(path, parent, kind, name, detail, node.start, node.end, values=values)
        )
        below = [(child, (*path, *rest), index) for child, rest in _places(node, kind)]
        waiting.extend(reversed(below))


def _places(node: TextSpan, kind: str) -> Iterator[tuple[TextSpan, Path]]:
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
            yield TextSpan(node.end, node.end, "scalar"), (key,)


def _on_one_line(value: TextSpan, text: str) -> str:
    written = _written(value, text)
    written = written.strip("{}") if value.is_flow and value.kind == "map" else written
    return written if len(written) <= MOST_TEXT else written[: MOST_TEXT - 1] + "…"


def _written(value: TextSpan, text: str) -> str:
    if value.kind == "map" and not value.is_flow:
        return ", ".join(f"{key}: {_written(part, text)}" for key, part in value.parts.items())
    written = value.text if value.kind == "scalar" else text[value.start : value.end]
    return " ".join(written.split())
