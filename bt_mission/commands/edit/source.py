"""A text with the places of its nodes, and the edits of single places."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from bt_mission.base.diagnostics import InputError
from bt_mission.base.errors import BtMissionError
from bt_mission.commands.edit.scalars import as_text
from bt_mission.commands.edit.spans import Path, TextSpan, read_spans
from bt_mission.language.file import MissionFile, TreeDefinition
from bt_mission.language.nodes.base import CompositeNode
from bt_mission.language.nodes.registry import KINDS

STEP = 2
"""Spaces by which a node is indented below its key."""

_COMMENT = re.compile(r"[ \t]+#[^\n]*")
LIST_KEYS = frozenset(kind for kind, model in KINDS.items() if issubclass(model, CompositeNode))
CHILD_KEYS = ("invert", "do", "then", "else")
_ROOT_ORDER = tuple(MissionFile.model_fields)
_TREE_ORDER = tuple(TreeDefinition.model_fields)


class PatchError(BtMissionError):
    """An act that is not possible at its place."""

    code = "BT-1301"


@dataclass(frozen=True)
class Edit:
    """A replacement: the offsets of the old text, and the new text."""

    start: int
    end: int
    text: str


Edits: TypeAlias = tuple[Edit, ...]


def applied(text: str, edits: Edits) -> str:
    """Return a text with edits, which are in the order of the text."""
    parts, at = [], 0
    for edit in edits:
        parts += [text[at : edit.start], edit.text]
        at = edit.end
    return "".join((*parts, text[at:]))


def dotted(path: Path) -> str:
    """Return a path as people read it."""
    return ".".join(map(str, path)) or "the mission"


# ---- pieces of text ------------------------------------------------------------------------------


@dataclass(frozen=True)
class Piece:
    """A node as text: its first line begins at column 0, the others are indented as below it.

    Attributes:
        above: Comment lines that belong to it, without their indentation.
        tail: A comment behind its last line.
    """

    text: str
    raw: Any
    above: tuple[str, ...] = ()
    tail: str = ""

    @classmethod
    def of(cls, node: str) -> Piece:
        """Return a node that is given as YAML."""
        text = node.strip("\n")
        span = read_spans(text, is_part=True)
        if span.kind != "map":
            raise PatchError("expected a node")
        return cls(text, span.raw)

    def at(self, column: int) -> str:
        """Return it with all lines but the first one indented for a column."""
        return indented(self.text, column) + self.tail

    @property
    def flow(self) -> str:
        """It on one line, in braces."""
        return Source(self.text).flow(read_spans(self.text, is_part=True))

    @property
    def in_block(self) -> Piece:
        """It without the braces around a single key, as people write it in a block."""
        span = read_spans(self.text, is_part=True)
        if not span.is_flow or span.kind != "map" or len(span.parts) != 1 or "\n" in self.text:
            return self
        (entry,) = span.keys.values()
        inside = self.text[entry.start : span.end - 1].rstrip()
        try:
            same = read_spans(inside, is_part=True).raw == self.raw
        except InputError:
            same = False
        return Piece(inside, self.raw, self.above, self.tail) if same else self


def indented(text: str, by: int) -> str:
    """Return a text with all lines but the first one indented by more spaces."""
    first, *rest = text.split("\n")
    return "\n".join([first, *(" " * by + line if line.strip() else line for line in rest)])


def _dedented(text: str, column: int) -> str:
    first, *rest = text.split("\n")
    return "\n".join([first, *(line[min(column, _margin(line)) :] for line in rest)])


def _margin(line: str) -> int:
    return len(line) - len(line.lstrip(" "))


def block_wrap(kind: str, value: str, piece: Piece) -> Piece:
    """Return a node in a new one of a kind, in a block."""
    text = piece.text + piece.tail
    is_block = not read_spans(piece.text, is_part=True).is_flow
    below = f"\n{' ' * STEP}{indented(text, STEP)}" if is_block else f" {text}"
    if kind in LIST_KEYS:
        lines = f"{kind}:\n{' ' * STEP}- {indented(text, 2 * STEP)}"
    elif kind == "invert":
        lines = f"invert:{below}"
    else:
        lines = f"{kind}: {value}\ndo:{below}" + ("\nthen:" if kind == "finally" else "")
    return Piece(lines, None)


# ---- places in a text ----------------------------------------------------------------------------


class Source:
    """A text with its spans."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.root = read_spans(text)

    def node(self, path: Path) -> TextSpan:
        """Return the node at a path, which is below the root. Raises PatchError."""
        span = self._reached(path)
        if span is None or span.kind != "map" or not path:
            raise PatchError(f"there is no node at {dotted(path)}")
        return span

    def is_in_flow(self, path: Path) -> bool:
        """Return whether the collection around a place is in braces or brackets."""
        return any(
            span is not None and span.is_flow
            for span in (self.root.find(path[:depth]) for depth in range(len(path)))
        )

    def piece(self, path: Path) -> Piece:
        """Return a node with the comments that belong to it."""
        span = self.node(path)
        if self.is_in_flow(path):
            return Piece(self.flow(span), span.raw)
        start, end = self._region(path)
        head = self.text[start : self._line_start(self._head(path))]
        above = tuple(line.strip() for line in head.splitlines())
        body = self.text[span.start : end].rstrip("\n")
        tail = body[span.end - span.start :]
        is_behind = "\n" not in tail
        cut = self.cut(span) if is_behind else _dedented(body, self._column(span.start))
        return Piece(cut, span.raw, above, tail.rstrip() if is_behind else "")

    def cut(self, span: TextSpan) -> str:
        """Return the text of a value, its lines indented as below column 0."""
        return _dedented(self.text[span.start : span.end], self._column(span.start))

    def flow(self, span: TextSpan) -> str:
        """Return a value on one line, its scalars as they are written."""
        written = self.text[span.start : span.end]
        if span.kind in ("scalar", "alias"):
            if span.style in ("|", ">"):
                raise PatchError("a text of several lines cannot be in braces")
            return " ".join(written.split("\n")) if "\n" in written else written
        if span.is_flow and "\n" not in written and written[:1] in "{[":
            return written
        if "#" in written and any(_COMMENT.finditer(written)):
            raise PatchError("comments would be lost in braces; edit the text")
        if span.kind == "list":
            return "[" + ", ".join(map(self.flow, span.items)) + "]"
        pairs = (
            f"{self.text[entry.start : entry.end]}: {self.flow(span.parts[key])}"
            for key, entry in span.keys.items()
        )
        return "{" + ", ".join(pairs) + "}"

    # ---- edits ---------------------------------------------------------------------------

    def insertion(self, target: Path, piece: Piece) -> Edits:
        """Return the edit that puts a node at a target. Raises PatchError."""
        if not target:
            raise PatchError("expected a place for a node, got the whole text")
        parent = self._reached(target[:-1])
        where = target[-1]
        if isinstance(where, str):
            if parent is None or parent.kind != "map":
                raise PatchError(f"there is no place for a node at {dotted(target)}")
            return (self._in_slot(parent, target, piece),)
        key = target[-2] if len(target) > 1 else ""
        if parent is None or key not in LIST_KEYS:
            raise PatchError(f"there is no list of nodes at {dotted(target[:-1])}")
        return (self.item(target, parent, piece),)

    def item(self, target: Path, parent: TextSpan, piece: Piece) -> Edit:
        """Return the edit that puts an item into a list. Raises PatchError."""
        where = target[-1]
        assert isinstance(where, int)
        if parent.kind != "list" and not parent.is_empty:
            raise PatchError(f"there is no list at {dotted(target[:-1])}")
        if not 0 <= where <= len(parent.items):
            raise PatchError(f"expected an index from 0 to {len(parent.items)}, got {where}")
        if self.is_in_flow(target[:-1]):
            return self._in_brackets(parent, where, piece)
        if not parent.items:
            return self._first_item(target[:-1], parent, piece)
        if parent.is_flow:
            return self._in_brackets(parent, where, piece)
        return self._in_list(target[:-1], parent, where, piece)

    def _in_list(self, path: Path, parent: TextSpan, where: int, piece: Piece) -> Edit:
        column = self._column(parent.start)
        lines = self._item(column, piece)
        if where < len(parent.items):
            start, _ = self._region((*path, where))
            return Edit(start, start, lines)
        _, end = self._region((*path, where - 1))
        if not self.text[:end].endswith("\n"):
            return Edit(end, end, "\n" + lines.rstrip("\n"))
        return Edit(end, end, lines)

    @staticmethod
    def _item(column: int, piece: Piece) -> str:
        block, margin = piece.in_block, " " * column
        lines = [*(margin + line for line in piece.above), f"{margin}- {block.at(column + STEP)}"]
        return "\n".join(lines) + "\n"

    def _first_item(self, path: Path, parent: TextSpan, piece: Piece) -> Edit:
        holder = self.root.find(path[:-1])
        assert holder is not None
        entry = holder.keys[str(path[-1])]
        column = self._column(entry.start) + STEP
        end = max(entry.colon, parent.end)
        tail = _COMMENT.match(self.text, end)
        kept = tail.group() if tail else ""
        lines = self._item(column, piece).rstrip("\n")
        return Edit(entry.colon, self._line_end(end), f"{kept}\n{lines}")

    def _in_brackets(self, parent: TextSpan, where: int, piece: Piece) -> Edit:
        if not parent.items:
            if parent.kind == "scalar":
                return Edit(parent.start, parent.end, f" [{piece.flow}]")
            return Edit(parent.start, parent.end, f"[{piece.flow}]")
        if where < len(parent.items):
            start = parent.items[where].start
            return Edit(start, start, f"{piece.flow}, ")
        end = parent.items[-1].end
        return Edit(end, end, f", {piece.flow}")

    def _in_slot(self, parent: TextSpan, target: Path, piece: Piece) -> Edit:
        key = str(target[-1])
        value = parent.parts.get(key)
        if value is not None and not value.is_empty:
            raise PatchError("there is a node already; wrap it in a sequence first")
        if self.is_in_flow(target):
            if value is None:
                return Edit(parent.end - 1, parent.end - 1, f", {key}: {piece.flow}")
            entry = parent.keys[key]
            return Edit(entry.colon, max(value.end, entry.colon), f" {piece.flow}")
        margin = self._column(parent.start)
        lines = self.below(margin, piece)
        if value is None:
            end = self._behind(parent, key, ())
            return Edit(end, end, f"\n{' ' * margin}{key}:{lines}")
        entry = parent.keys[key]
        end = max(value.end, entry.colon)
        tail = _COMMENT.match(self.text, end)
        return Edit(entry.colon, self._line_end(end), f"{tail.group() if tail else ''}{lines}")

    @staticmethod
    def below(margin: int, piece: Piece) -> str:
        """Return the lines of a node below a key, which is indented by a margin."""
        block, inner = piece.in_block, " " * (margin + STEP)
        lines = [*(inner + line for line in piece.above), inner + block.at(margin + STEP)]
        return "\n" + "\n".join(lines)

    def at_end(self, lines: str) -> Edit:
        """Return the edit that puts lines at the end of the text."""
        end = len(self.text)
        is_whole = not self.text or self.text.endswith("\n")
        return Edit(end, end, lines if is_whole else f"\n{lines}")

    def removal(self, path: Path) -> Edits:
        """Return the edits that remove a node; a list without nodes is empty then."""
        parent = self._reached(path[:-1])
        assert parent is not None
        last = path[-1]
        if self.is_in_flow(path):
            return (self._from_brackets(path, parent),)
        if isinstance(last, int):
            start, end = self._region(path)
            if len(parent.items) > 1 or len(path) < 2:
                return (self._line_cut(start, self._behind_blank(start, end)),)
            return self._emptied(path[:-1], start, end, " []")
        span = self.node(path)
        entry = parent.keys[last]
        if self._line_start(entry.start) == self._line_start(span.start):
            return (Edit(entry.colon, span.end, ""),)
        start, end = self._region(path)
        return self._emptied(path, start, end, "")

    def _emptied(self, path: Path, start: int, end: int, instead: str) -> Edits:
        holder = self._reached(path[:-1])
        assert holder is not None
        colon = holder.keys[str(path[-1])].colon
        cut = self._line_cut(start, end)
        return (Edit(colon, colon, instead), cut) if instead else (cut,)

    def _behind_blank(self, start: int, end: int) -> int:
        """Return the end of lines with the blank line behind, if one is before them, too."""
        above = self.text[self._line_start(max(start - 1, 0)) : start]
        behind = re.compile(r"(?:[ \t]*\n)+").match(self.text, end)
        is_first = above.rstrip().endswith(":")
        return behind.end() if behind and (is_first or not above.strip()) else end

    def _line_cut(self, start: int, end: int) -> Edit:
        """Return the deletion of lines, and of the line feed before them at the end of a file."""
        if end == len(self.text) and not self.text.endswith("\n") and start:
            return Edit(start - 1, end, "")
        return Edit(start, end, "")

    def _from_brackets(self, path: Path, parent: TextSpan) -> Edit:
        last = path[-1]
        if isinstance(last, str):
            return Edit(parent.keys[last].colon, parent.parts[last].end, "")
        items = parent.items
        if last + 1 < len(items):
            return Edit(items[last].start, items[last + 1].start, "")
        start = items[last - 1].end if last else items[last].start
        return Edit(start, items[last].end, "")

    def replacement(self, path: Path, piece: Piece) -> Edits:
        """Return the edit that puts a node in a block in the place of another."""
        span = self.node(path)
        last = path[-1]
        parent = self.root.find(path[:-1])
        assert parent is not None
        column = self._column(span.start)
        if isinstance(last, str):
            entry = parent.keys[last]
            if self._line_start(entry.start) == self._line_start(span.start):
                margin = self._column(entry.start) + STEP
                lines = f"\n{' ' * margin}{indented(piece.in_block.text, margin)}"
                return (Edit(entry.colon, span.end, lines),)
        return (Edit(span.start, span.end, indented(piece.text, column)),)

    # ---- fields --------------------------------------------------------------------------

    def valued(self, path: Path, keys: Sequence[str], value: str) -> Edits:
        """Return the edit that gives a field a value."""
        depth = 0
        whole = (*path, *keys)
        span = self.root
        while depth < len(whole) and (inner := span.child(whole[depth])) is not None:
            span, depth = inner, depth + 1
            if span.kind == "alias":
                raise PatchError("this value is an alias; edit the value of its anchor")
        rest = [str(key) for key in whole[depth:]]
        if not whole[:depth] and span.is_empty:
            return (self.at_end(self._pair(rest, value, is_plain=True) + "\n"),)
        if not rest:
            return (self._new_value(whole, span, value),)
        parent_path = whole[:depth]
        if span.kind == "map" and (span.parts or not span.is_flow):
            is_plain = not path and len(rest) > 1
            new = self._pair(rest, value, is_plain=is_plain and not span.is_flow)
            return (self._new_pair(parent_path, span, rest[0], new),)
        if span.is_empty or (span.kind == "map" and not span.parts):
            inside = self._pair(rest, value, is_plain=False)
            return (self._new_value(parent_path, span, "{" + inside + "}"),)
        if keys[:1] == ("tree",) or list(keys[:1]) == ["tree"]:
            named = self.text[span.start : span.end]
            inside = self._pair(rest, value, is_plain=False)
            return (Edit(span.start, span.end, f"{{name: {named}, {inside}}}"),)
        raise PatchError(f"{dotted(parent_path)} is a value, and has no fields")

    @staticmethod
    def _pair(keys: Sequence[str], value: str, *, is_plain: bool) -> str:
        first, *rest = (as_text(key) for key in keys)
        if is_plain and rest:
            lines = [f"{first}:"]
            for number, key in enumerate(rest, 1):
                lines.append(f"{' ' * STEP * number}{key}:")
            return "\n".join(lines) + f" {value}"
        for key in reversed(rest):
            value = f"{{{key}: {value}}}"
        return f"{first}: {value}"

    def _new_value(self, path: Path, span: TextSpan, value: str) -> Edit:
        parent = self.root.find(path[:-1])
        assert parent is not None
        if isinstance(path[-1], int):
            return Edit(span.start, span.end, value)
        entry = parent.keys[path[-1]]
        if span.end <= entry.colon:
            return Edit(entry.colon, entry.colon, f" {value}")
        if self._line_start(span.start) == self._line_start(entry.start):
            return Edit(span.start, span.end, value)
        return Edit(entry.colon, span.end, f" {value}")

    def _new_pair(self, path: Path, parent: TextSpan, key: str, pair: str) -> Edit:
        if parent.is_flow or self.is_in_flow(path):
            end = max((part.end for part in parent.parts.values()), default=parent.end - 1)
            end = max(end, *(entry.colon for entry in parent.keys.values()))
            return Edit(end, end, f", {pair}")
        margin = self._column(parent.start)
        order = _order(path, parent)
        end = self._behind(parent, key, order)
        lines = indented(pair, margin)
        if end < 0:
            return Edit(parent.start, parent.start, f"{lines}\n{' ' * margin}")
        return Edit(end, end, f"\n{' ' * margin}{lines}")

    def _behind(self, parent: TextSpan, key: str, order: Sequence[str]) -> int:
        """Return the end of the last line of the entry behind which a key is written.

        It is -1 if the key is written before all others.
        """
        rank = {name: number for number, name in enumerate(order)}
        mine = rank.get(key, len(rank))
        names = list(parent.keys)
        before = [name for name in names if rank.get(name, len(rank)) <= mine]
        later = [name for name in names if rank.get(name, len(rank)) > mine]
        if later and before:
            before = names[: names.index(later[0])] or before
        if not before:
            return -1
        last = before[-1]
        part = parent.parts[last]
        end = max(part.end, parent.keys[last].colon)
        return self._line_end(self._with_comments(end, self._column(parent.start)))

    def removed_key(self, path: Path) -> Edits:
        """Return the edit that removes a key with its value."""
        parent, key = self._reached(path[:-1]), str(path[-1])
        if parent is None or key not in parent.keys:
            return ()
        entry, part = parent.keys[key], parent.parts[key]
        end = max(part.end, entry.colon)
        names = list(parent.keys)
        if parent.is_flow or self.is_in_flow(path):
            at = names.index(key)
            if at + 1 < len(names):
                return (Edit(entry.start, parent.keys[names[at + 1]].start, ""),)
            if at:
                before = names[at - 1]
                start = max(parent.parts[before].end, parent.keys[before].colon)
                return (Edit(start, end, ""),)
            return (Edit(entry.start, end, ""),)
        if len(names) == 1:
            raise PatchError(f"{key} is the only key here")
        end = self._line_end(self._with_comments(end, self._column(parent.start)))
        if key == names[0] and self._line_start(entry.start) != entry.start:
            return (Edit(entry.start, parent.keys[names[1]].start, ""),)
        return (self._line_cut(self._line_start(entry.start), min(end + 1, len(self.text))),)

    # ---- lines ---------------------------------------------------------------------------

    def _reached(self, path: Path) -> TextSpan | None:
        span: TextSpan | None = self.root
        for key in path:
            if span is not None and span.kind == "alias":
                raise PatchError("this node is an alias; edit the node of its anchor")
            span = None if span is None else span.child(key)
        if span is not None and span.kind == "alias":
            raise PatchError("this node is an alias; edit the node of its anchor")
        return span

    def _head(self, path: Path) -> int:
        """Return the offset of the dash before an item, or of a value below its key."""
        span = self.root.find(path)
        parent = self.root.find(path[:-1])
        assert span is not None
        assert parent is not None
        if isinstance(path[-1], str):
            return span.start
        column = self._column(parent.start)
        if path[-1] == 0:
            return parent.start
        before = parent.items[path[-1] - 1].end
        match = re.compile(rf"\n {{{column}}}-(?=\s)").search(self.text, max(before - 1, 0))
        if match is None:
            raise PatchError("the dash of this item shares its line with others; edit the text")
        return match.end() - 1

    def _region(self, path: Path) -> tuple[int, int]:
        """Return the lines of a node in a block, with the comments that belong to it."""
        span = self.root.find(path)
        assert span is not None
        head = self._head(path)
        start = self._line_start(head)
        if self.text[start:head].strip():
            raise PatchError("this node shares its line with others; edit the text")
        column = head - start
        while start:
            above = self._line_start(start - 1)
            line = self.text[above : start - 1]
            if _margin(line) != column or line.strip()[:1] != "#":
                break
            start = above
        is_item = isinstance(path[-1], int)
        end = self._with_comments(span.end, column if is_item else column - 1)
        return start, min(self._line_end(end) + 1, len(self.text))

    def _with_comments(self, end: int, column: int) -> int:
        """Return an offset behind comment lines that follow and are indented more than a column."""
        at = self._line_end(end)
        last = end
        while at < len(self.text):
            stop = self._line_end(at + 1)
            line = self.text[at + 1 : stop]
            if line.strip()[:1] != "#" or _margin(line) <= column:
                break
            last = at = stop
        return last

    def _line_start(self, offset: int) -> int:
        return self.text.rfind("\n", 0, offset) + 1

    def _line_end(self, offset: int) -> int:
        end = self.text.find("\n", offset)
        return len(self.text) if end < 0 else end

    def _column(self, offset: int) -> int:
        return offset - self._line_start(offset)


def _order(path: Path, parent: TextSpan) -> Sequence[str]:
    """Return the usual order of the keys of a mapping; children stand last."""
    if not path:
        return _ROOT_ORDER
    if len(path) == 2 and path[0] == "trees":
        return _TREE_ORDER
    kind = next((key for key in parent.keys if key in KINDS and key != "timeout"), "")
    kind = kind or next(iter(parent.keys))
    if kind not in KINDS:
        return ()
    if kind in LIST_KEYS or kind == "invert":
        return ("name", kind, *KINDS[kind].keys)
    modifiers = [key for key in KINDS[kind].keys if key not in (kind, "name", *CHILD_KEYS)]
    return (kind, "name", *modifiers, *CHILD_KEYS)


def children_of(span: TextSpan) -> Iterator[Path]:
    """Yield the paths of the nodes directly below a node, relative to it."""
    for key, part in span.parts.items():
        if key in LIST_KEYS and part.kind == "list":
            yield from ((key, index) for index in range(len(part.items)))
        elif key in CHILD_KEYS and part.kind == "map":
            yield (key,)
