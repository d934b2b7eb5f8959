"""The offsets of every part of a YAML text, for patches that leave the rest of it unchanged."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from hashlib import sha256
from typing import Any, Literal

import yaml  # type: ignore[import-untyped]

from bt_mission.base.diagnostics import Diagnostic, InputError
from bt_mission.base.yaml.composer import compose
from bt_mission.base.yaml.document import Key, refuse_large
from bt_mission.base.yaml.parser_messages import MAX_DEPTH

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_COLON = re.compile(r"[ \t]*:")

Path = tuple[Key, ...]

KEPT = 3
"""Texts whose spans are kept: an act needs those of the text before it and after it."""


@dataclass(slots=True, eq=False)
class Entry:
    """A key of a mapping: its offsets, and the offset behind its colon."""

    start: int
    end: int
    colon: int


@dataclass(slots=True, eq=False)
class TextSpan:
    """A value and its place: offsets of its first character, and behind its last one.

    Attributes:
        text: The content of a scalar; the name of an alias.
        meant: Of an alias: what stands for the value of its anchor, which the last definition of
            that name before it gives.
        is_flow: Whether a collection is in braces or brackets.
        style: Of a scalar: empty if it is plain.
    """

    start: int
    end: int
    kind: Literal["scalar", "map", "list", "alias"]
    text: str = ""
    style: str = ""
    meant: str = ""
    is_flow: bool = False
    keys: dict[str, Entry] = field(default_factory=dict)
    parts: dict[str, TextSpan] = field(default_factory=dict)
    items: list[TextSpan] = field(default_factory=list)

    def child(self, key: Key) -> TextSpan | None:
        """Return one part, or None without it."""
        if isinstance(key, str):
            return self.parts.get(key)
        return self.items[key] if 0 <= key < len(self.items) else None

    def find(self, path: Sequence[Key]) -> TextSpan | None:
        """Return the part at a path, or None without it."""
        span: TextSpan | None = self
        for key in path:
            span = None if span is None else span.child(key)
        return span

    @property
    def is_empty(self) -> bool:
        """Whether it is nothing: a key without a value, or `null`."""
        return self.kind == "scalar" and not self.style and self.text in ("", "~", "null")

    @property
    def raw(self) -> Any:
        """The value without its place and layout, for comparisons."""
        match self.kind:
            case "map":
                return {key: part.raw for key, part in self.parts.items()}
            case "list":
                return [item.raw for item in self.items]
            case "scalar":
                return None if self.is_empty else (not self.style, self.text)
        return ("*", self.text, self.meant)

    @property
    def plain(self) -> Any:
        """The value with every scalar as a text."""
        match self.kind:
            case "map":
                return {key: part.plain for key, part in self.parts.items()}
            case "list":
                return [item.plain for item in self.items]
        return self.text

    def walk(self) -> Iterator[TextSpan]:
        """Yield it and all of its parts."""
        yield self
        for part in (*self.parts.values(), *self.items):
            yield from part.walk()


@lru_cache(maxsize=KEPT)
def read_spans(text: str, file: str = "<text>", *, is_part: bool = False) -> TextSpan:
    """Return the value of a YAML text with its places; those of the last texts are kept.

    Args:
        text: The text.
        file: For errors.
        is_part: Whether it is a part of a text that may define the anchors of its aliases.

    Raises:
        InputError: The text is not YAML of the kind that missions are.
    """
    refuse_large(text, file)
    try:
        reader = _Reader(text, is_part=is_part)
        for event in yaml.parse(text, Loader=_LOADER):
            reader.take(event)
    except (yaml.YAMLError, RecursionError, _UnexpectedFormError):
        compose(text, file)  # raises the error of the loader, with its place
        raise InputError([Diagnostic("BT-105", "a form of YAML without patches", file)]) from None
    if len(reader.roots) > 1:
        compose(text, file)
    return reader.roots[0] if reader.roots else TextSpan(0, 0, "scalar")


class _UnexpectedFormError(Exception):
    """A key that is not a scalar, or occurs twice; an alias of nothing; a nesting too deep."""


@dataclass
class _Reader:
    """Builds spans from the events of the parser."""

    text: str
    is_part: bool = False
    roots: list[TextSpan] = field(default_factory=list)
    stack: list[TextSpan] = field(default_factory=list)
    pending: list[tuple[str, Entry] | None] = field(default_factory=list)
    """The key of each open mapping whose value is next."""
    anchors: dict[str, str | TextSpan | None] = field(default_factory=dict)
    """The digest of the value of each anchor so far; of an open one its value."""

    def take(self, event: Any) -> None:
        start, end = event.start_mark.index, event.end_mark.index
        match event:
            case yaml.ScalarEvent():
                style = event.style if event.style in ("'", '"', "|", ">") else ""
                if style in ("|", ">"):
                    end = start + len(self.text[start:end].rstrip())
                span = TextSpan(start, end, "scalar", event.value, style)
                self.add(span)
                if event.anchor is not None:
                    self.anchors[event.anchor] = _short(span)
            case yaml.AliasEvent():
                meant = self.anchors.get(event.anchor, "" if self.is_part else None)
                if not isinstance(meant, str):
                    raise _UnexpectedFormError
                self.add(TextSpan(start, end, "alias", event.anchor, meant=meant))
            case yaml.MappingStartEvent():
                self.open(TextSpan(start, end, "map", is_flow=bool(event.flow_style)), event.anchor)
            case yaml.SequenceStartEvent():
                self.open(
                    TextSpan(start, end, "list", is_flow=bool(event.flow_style)), event.anchor
                )
            case yaml.MappingEndEvent() | yaml.SequenceEndEvent():
                span = self.stack.pop()
                self.pending.pop()
                span.end = end if span.is_flow else _end_of(span)
                for name in [name for name, value in self.anchors.items() if value is span]:
                    self.anchors[name] = _short(span)

    def open(self, span: TextSpan, anchor: str | None) -> None:
        self.add(span)
        if anchor is not None:
            self.anchors[anchor] = span
        if len(self.stack) >= MAX_DEPTH:
            raise _UnexpectedFormError
        self.stack.append(span)
        self.pending.append(None)

    def add(self, span: TextSpan) -> None:
        if not self.stack:
            self.roots.append(span)
        elif self.stack[-1].kind == "list":
            self.stack[-1].items.append(span)
        elif (pending := self.pending[-1]) is None:
            self.pending[-1] = span.text, self.entry(span)
        else:
            name, entry = pending
            if span.kind == "scalar" and not span.style and not span.text:
                span.start = span.end = entry.colon
            self.stack[-1].keys[name], self.stack[-1].parts[name] = entry, span
            self.pending[-1] = None

    def entry(self, span: TextSpan) -> Entry:
        colon = _COLON.match(self.text, span.end)
        if span.kind != "scalar" or colon is None or span.text in self.stack[-1].keys:
            raise _UnexpectedFormError
        return Entry(span.start, span.end, colon.end())


def _short(span: TextSpan) -> str:
    """Return what distinguishes a value from all others, in a few bytes."""
    return sha256(repr(span.raw).encode("utf-8", "surrogatepass")).hexdigest()


def _end_of(span: TextSpan) -> int:
    """Return the end of the last part of a block; a key without a value ends behind its colon."""
    parts = [*span.parts.values(), *span.items]
    return max([part.end for part in parts] + [entry.colon for entry in span.keys.values()])
