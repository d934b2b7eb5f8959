"""Graphical acts on a mission as patches of its text, which leave all other lines unchanged.

A target is the path at which a node stands afterwards: the index in a list of children, or a key
such as `do`. Each patch is compared with the act on the data: what the text means afterwards is
what the act means, or the act is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

from bt_mission.base.diagnostics import InputError, quoted
from bt_mission.commands.edit.scalars import as_text
from bt_mission.commands.edit.source import (
    LIST_KEYS,
    Edit,
    Edits,
    PatchError,
    Piece,
    Source,
    applied,
    block_wrap,
    children_of,
)
from bt_mission.commands.edit.spans import Path, read_spans

UNTITLED = "untitled"
"""The name of a new mission."""


def add(text: str, target: Path, node: str) -> Edits:
    """Put a new node, given as YAML, at a target."""
    source = Source(text)
    piece = Piece.of(node)
    return _checked(source, source.insertion(target, piece), lambda data: _put(data, target, piece))


def begin(text: str, node: str) -> Edits:
    """Make a node the tree of a mission that has none; of an empty text, make a mission."""
    source = Source(text)
    if not source.root.is_empty:
        return add(text, ("tree",), node)
    piece = Piece.of(node)
    lines = f"mission: {UNTITLED}\ntree:{source.below(0, piece)}\n"
    expected = {**read_spans(f"mission: {UNTITLED}").raw, "tree": piece.raw}
    return _checked(source, (source.at_end(lines),), lambda _: expected)


def append(text: str, key: str, item: str) -> Edits:
    """Put an item, given as YAML, at the end of the list of a key of the file."""
    source = Source(text)
    if source.root.kind != "map" and not source.root.is_empty:
        raise PatchError("expected keys with values at the top of the text")
    piece = Piece.of(item)
    parent = source.root.parts.get(key)
    if parent is None:
        edit = source.at_end(f"{key}:\n  - {piece.text}\n")
    else:
        edit = source.item((key, len(parent.items)), parent, piece)
    items = [*((source.root.raw or {}).get(key) or []), piece.raw]
    return _checked(source, (edit,), lambda data: {**(data or {}), key: items})


def delete(text: str, path: Path) -> Edits:
    """Delete a node with all below it."""
    source = Source(text)
    source.node(path)
    return _checked(source, source.removal(path), lambda data: _take(data, path))


def move(text: str, path: Path, target: Path) -> Edits:
    """Move a node to a target; indices are those before the move."""
    source = Source(text)
    piece = source.piece(path)
    if target[: len(path)] == path and len(target) > len(path):
        raise PatchError("a node cannot be moved into itself")
    if target in (path, _next(path)):
        return ()

    def act(data: Any) -> Any:
        data = _put(data, target, piece)
        return _take(data, _shifted(path, target))

    edits = _merged(source.removal(path), source.insertion(target, piece))
    return _checked(source, edits, act)


def copy(text: str, path: Path, target: Path | None = None) -> Edits:
    """Copy a node to a target, by default behind itself."""
    source = Source(text)
    piece = source.piece(path)
    target = _next(path) if target is None else target
    if target == path and not isinstance(path[-1], int):
        raise PatchError("there is room for one node only; wrap it in a sequence first")
    return _checked(source, source.insertion(target, piece), lambda data: _put(data, target, piece))


def wrap(text: str, path: Path, kind: str, value: str) -> Edits:
    """Put a node into a new one of a kind, given the value of its key as YAML."""
    source = Source(text)
    span = source.node(path)
    piece = Piece(source.flow(span) if source.is_in_flow(path) else source.cut(span), span.raw)
    outer: dict[str, Any]
    if kind in LIST_KEYS:
        outer = {kind: [piece.raw]}
    elif kind == "invert":
        outer = {kind: piece.raw}
    else:
        outer = {kind: read_spans(value).raw, "do": piece.raw}
        if kind == "finally":
            outer["then"] = None
    if source.is_in_flow(path):
        inner = f"[{piece.text}]" if kind in LIST_KEYS else piece.text
        inside = f"{kind}: {value}, do: {inner}" if "do" in outer else f"{kind}: {inner}"
        edits: Edits = (Edit(span.start, span.end, "{" + inside + "}"),)
    else:
        edits = source.replacement(path, block_wrap(kind, value, piece))
    return _checked(source, edits, lambda data: _replaced(data, path, outer))


def unwrap(text: str, path: Path) -> Edits:
    """Put the only node below a node in its place."""
    source = Source(text)
    span = source.node(path)
    inner = [(*path, *rest) for rest in children_of(span)]
    if len(inner) != 1:
        raise PatchError(f"expected one node below this node, got {len(inner)}")
    child = source.node(inner[0])
    piece = Piece(source.flow(child) if source.is_in_flow(path) else source.cut(child), child.raw)
    if source.is_in_flow(path):
        edits: Edits = (Edit(span.start, span.end, piece.text),)
    else:
        edits = source.replacement(path, piece)
    return _checked(source, edits, lambda data: _replaced(data, path, piece.raw))


def rename(text: str, path: Path, name: str) -> Edits:
    """Give a node a name, or none."""
    return set_field(text, path, ("name",), as_text(name) if name else None)


def set_field(text: str, path: Path, keys: Sequence[str], value: str | None) -> Edits:
    """Give a field of a node a value as YAML on one line, or remove it.

    Args:
        path: Of the node; empty for the mission itself.
        keys: Lead to the field, such as `("turn", "angle")`.
    """
    if not keys:
        raise PatchError("expected a field")
    source = Source(text)
    if path:
        source.node(path)
    new = None if value is None else _flow_value(value)
    whole = (*path, *keys)
    edits = source.removed_key(whole) if new is None else source.valued(path, keys, new)
    raw = None if new is None else read_spans(new).raw
    is_removed = new is None

    def act(data: Any) -> Any:
        return _without(data, whole) if is_removed else _with(data, whole, raw)

    return _checked(source, edits, act)


def _flow_value(value: str) -> str:
    """Return a value that can stand on one line, in braces, too. Raises PatchError."""
    written = value.strip() or "''"
    try:
        items = read_spans(f"[{written}]").items
    except InputError as error:
        raise PatchError(error.diagnostics[0].message) from None
    if "\n" in written or len(items) != 1 or items[0].end != len(written) + 1:
        raise PatchError(f"expected one value on one line, got {quoted(written)}")
    return written


def _next(path: Path) -> Path:
    last = path[-1] if path else ""
    return (*path[:-1], last + 1) if isinstance(last, int) else path


def _shifted(path: Path, target: Path) -> Path:
    """Return a path after an insertion at a target."""
    at, last = len(target) - 1, target[-1]
    if not isinstance(last, int) or len(path) <= at or path[:at] != target[:-1]:
        return path
    own = path[at]
    return (*path[:at], own + 1, *path[at + 1 :]) if isinstance(own, int) and own >= last else path


def _merged(*edits: Edits) -> Edits:
    """Return edits of one text in its order; those that overlap are refused."""
    ordered = sorted((edit for some in edits for edit in some), key=lambda edit: edit.start)
    for first, second in pairwise(ordered):
        if first.end > second.start:
            raise PatchError("this place is too close; edit the text")
    return tuple(ordered)


# ---- the same on data ----------------------------------------------------------------------------


def _checked(source: Source, edits: Edits, act: Callable[[Any], Any]) -> Edits:
    """Return edits if the text means what the act means afterwards.

    Raises:
        PatchError: It does not.
    """
    edits = tuple(edit for edit in edits if source.text[edit.start : edit.end] != edit.text)
    expected = act(source.root.raw)
    try:
        is_right = read_spans(applied(source.text, edits)).raw == expected
    except InputError:
        is_right = False
    if not is_right:
        raise PatchError("the form of this place allows no such change; edit the text")
    return edits


def _at(data: Any, path: Path, change: Callable[[Any], Any]) -> Any:
    """Return data with a change of one part."""
    if not path:
        return change(data)
    key = path[0]
    if isinstance(key, int):
        items = list(data)
        items[key] = _at(items[key], path[1:], change)
        return items
    return {**(data or {}), key: _at((data or {}).get(key), path[1:], change)}


def _put(data: Any, target: Path, piece: Piece) -> Any:
    last = target[-1]

    def change(parent: Any) -> Any:
        if isinstance(last, int):
            return [*(parent or [])[:last], piece.raw, *(parent or [])[last:]]
        return {**parent, last: piece.raw}

    return _at(data, target[:-1], change)


def _take(data: Any, path: Path) -> Any:
    last = path[-1]

    def change(parent: Any) -> Any:
        if isinstance(last, int):
            return [*parent[:last], *parent[last + 1 :]]
        return {**parent, last: None}

    return _at(data, path[:-1], change)


def _replaced(data: Any, path: Path, value: Any) -> Any:
    return _at(data, path, lambda _: value)


def _with(data: Any, path: Path, value: Any) -> Any:
    def change(parent: Any) -> Any:
        if isinstance(parent, list):
            items = list(parent)
            items[int(path[-1])] = value
            return items
        return {**(parent or {}), path[-1]: value}

    inner = data
    for depth, key in enumerate(path[:-1], 1):
        inner = inner[key] if isinstance(key, int) else (inner or {}).get(key)
        if isinstance(inner, tuple):  # the short form of the use of a tree
            return _replaced(data, path[:depth], _with({"name": inner}, path[depth:], value))
    return _at(data, path[:-1], change)


def _without(data: Any, path: Path) -> Any:
    def change(parent: Any) -> Any:
        if not isinstance(parent, dict):
            return parent
        return {key: part for key, part in parent.items() if key != path[-1]}

    return _at(data, path[:-1], change)
