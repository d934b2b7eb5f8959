"""From YAML text to plain data with places, refusing what has no business in our files.

libyaml (through PyYAML, which rclpy already needs) delivers events with marks; this module
builds data and places from them. So it decides itself what a scalar means (the core schema of
YAML 1.2: `yes` is a text), and stops at a limit before anything has grown.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any

import yaml  # type: ignore[import-untyped]

from bt_mission.base.diagnostics import (
    MOST_DIAGNOSTICS,
    Diagnostic,
    InputError,
    diagnostic_at,
    quoted,
)
from bt_mission.base.text import is_shown
from bt_mission.base.yaml.parser_messages import MAX_DEPTH, TOO_DEEP, translate

MAX_VALUES = 100_000
"""Values in a document, with aliases expanded: the limit for an alias bomb."""

TEXT_WEIGHT = 10
"""Characters that count as another value if an alias repeats a text."""

MAX_INTEGER = 2**64
"""No ROS field holds a larger integer."""

_BREAK = re.compile("\r\n|[\n\r\x85\u2028\u2029]")
_SEPARATOR = re.compile("[\x85\u2028\u2029]")
"""YAML 1.1 and libyaml take them for the end of a line, and so of a comment; what shows a text does
not."""
_UNPRINTABLE = re.compile(
    "[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x84\x86-\x9f\ud800-\udfff\ufeff\ufffe\uffff]"
)
_DECIMAL_COMMA = re.compile(r"([0-9]+),([0-9]+)\s*[,}]")
_TAB_INDENT = re.compile(r"^ *\t", re.MULTILINE)
_WORDS = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}
_INTEGER = re.compile(r"[-+]?[0-9]+")
_PREFIXED = re.compile(r"0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_NUMBER_START = frozenset("+-.0123456789")
_QUOTES = frozenset("'\"")
_BLANK = frozenset("\t\n\r")
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


At = tuple[int, int]
"""Line and column, from 1."""


@dataclass(slots=True, eq=False)
class Place:
    """The place of a value (from 1), and those of its keys and parts.

    `text` is set for a text on a single line, so that a column within it is known.
    """

    line: int
    column: int
    keys: dict[str, At] | None = None
    parts: dict[str, Place] | list[Place] | None = None
    text: str | None = None

    def child(self, key: str | int) -> Place | None:
        """Return the place of one part, or None without it."""
        if isinstance(self.parts, dict) and isinstance(key, str):
            return self.parts.get(key)
        if isinstance(self.parts, list) and isinstance(key, int) and 0 <= key < len(self.parts):
            return self.parts[key]
        return None


@dataclass(slots=True, eq=False)
class _Open:
    """A mapping or list that is being read, or one with an anchor."""

    data: Any
    place: Place
    anchor: str | None = None
    size: int = 1
    height: int = 1
    closed: bool = False
    key: str | None = None
    key_at: At = (0, 0)


def _start(event: Any) -> At:
    return event.start_mark.line + 1, event.start_mark.column + 1


def _is_plain(event: Any) -> bool:
    return bool(event.implicit[0]) and event.style in (None, "")


def split_lines(text: str) -> tuple[str, ...]:
    """Return the lines of a text as YAML counts them."""
    return tuple(_BREAK.split(text))


def compose(text: str, file: str) -> tuple[Any, Place]:
    """Return the data of the one document in a text, and its places. Raises InputError."""
    reader = _EventReader(text.removeprefix("\ufeff"), file)
    reader.refuse_characters()
    try:
        for event in yaml.parse(reader.text, Loader=_LOADER):
            reader.take(event)
        reader.refuse_hidden()
    except yaml.YAMLError as error:
        reader.fail(*translate(error, reader.lines))
    except (RecursionError, MemoryError):
        reader.fail("BT-103", "the file is nested too deeply to be read", (1, 1))
    return reader.finish()


@dataclass
class _EventReader:
    text: str
    file: str
    lines: tuple[str, ...] = ()
    diagnostics: list[Diagnostic] = field(default_factory=list)
    stack: list[_Open] = field(default_factory=list)
    anchors: dict[str, _Open] = field(default_factory=dict)
    quoted: list[tuple[int, int]] = field(default_factory=list)
    """Where quoted texts begin and end."""
    values: int = 0
    documents: int = 0
    root: tuple[Any, Place] | None = None

    def __post_init__(self) -> None:
        self.lines = split_lines(self.text)

    def note(self, code: str, message: str, at: At, hint: str | None = None) -> None:
        if len(self.diagnostics) >= MOST_DIAGNOSTICS:
            raise InputError(self.diagnostics)
        self.diagnostics.append(diagnostic_at(code, at, self.file, self.lines, message, hint))

    def fail(self, code: str, message: str, at: At) -> None:
        self.note(code, message, at)
        raise InputError(self.diagnostics) from None

    def refuse_characters(self) -> None:
        """Refuse characters that YAML does not allow, and tabs that indent."""
        bad = _UNPRINTABLE.search(self.text)
        if bad:
            message = f"a control character (U+{ord(bad.group()):04X}); this is not text"
            self.fail("BT-102", message, self.at(bad.start()))
        for separator in _SEPARATOR.finditer(self.text):
            code = ord(separator.group())
            message = f"a line separator (U+{code:04X}), which looks like no end of a line"
            hint = f'write a line feed, or "\\u{code:04x}" in a double-quoted text'
            self.note("BT-102", message, self.at(separator.start()), hint)
        for tab in _TAB_INDENT.finditer(self.text):
            line = len(split_lines(self.text[: tab.start()]))
            self.note(
                "BT-104",
                "a tab in the indentation; YAML requires spaces",
                (line, tab.end() - tab.start()),
            )
            if len(self.diagnostics) == 20:
                break
        if self.diagnostics:
            raise InputError(self.diagnostics)

    def refuse_hidden(self) -> None:
        """Refuse characters outside of quoted texts that show nothing, or turn the direction."""
        hidden = {character for character in set(self.text) - _BLANK if not is_shown(character)}
        if not hidden:
            return
        matches = re.finditer(f"[{re.escape(''.join(sorted(hidden)))}]", self.text)
        quoted = iter([*self.quoted, (len(self.text), len(self.text))])
        start, end = next(quoted)
        for each in matches:
            while each.start() >= end:
                start, end = next(quoted)
            if each.start() < start:
                message = f"a character that cannot be seen (U+{ord(each.group()):04X})"
                hint = "remove it; only quoted texts may have it"
                self.note("BT-102", message, self.at(each.start()), hint)

    def at(self, offset: int) -> At:
        """Return line and column of an offset."""
        lines = split_lines(self.text[:offset])
        return len(lines), len(lines[-1]) + 1

    def finish(self) -> tuple[Any, Place]:
        if self.root is None or (self.root[0] is None and not self.diagnostics):
            self.fail("BT-109", "the file is empty", (1, 1))
        if self.diagnostics:
            raise InputError(sorted(self.diagnostics, key=attrgetter("line", "column")))
        assert self.root is not None
        return self.root

    def take(self, event: Any) -> None:
        """Handle one event of the YAML parser."""
        match event:
            case yaml.ScalarEvent():
                self.take_scalar(event)
            case yaml.MappingStartEvent():
                place = Place(*self.begin(event), keys={}, parts={})
                self.open(_Open({}, place, event.anchor), event)
            case yaml.SequenceStartEvent():
                place = Place(*self.begin(event), parts=[])
                self.open(_Open([], place, event.anchor), event)
            case yaml.MappingEndEvent() | yaml.SequenceEndEvent():
                done = self.stack.pop()
                done.closed = True
                self.add(done.data, done.place, done.size, done.height)
            case yaml.AliasEvent():
                self.take_alias(event)
            case yaml.DocumentStartEvent():
                self.documents += 1
                if self.documents > 1:
                    line, _ = _start(event)
                    self.fail("BT-108", "a second document; expected one per file", (line, 1))

    def begin(self, event: Any) -> At:
        """Return the place of a value, after its anchor on the same line; refuse a tag."""
        line, column = _start(event)
        if event.tag is not None:
            self.note("BT-108", f"the tag {quoted(event.tag)} is not allowed", (line, column))
        if event.anchor is None and event.tag is None:
            return line, column
        rest = self.lines[line - 1][column - 1 :] if line <= len(self.lines) else ""
        prefix = re.match(r"(?:[&!][^\s,\[\]{}]*\s+)+(?=\S)", rest)
        return line, column + (prefix.end() if prefix else 0)

    def open(self, new: _Open, event: Any) -> None:
        top = self.stack[-1] if self.stack else None
        if top is not None and isinstance(top.data, dict) and top.key is None:
            self.fail(
                "BT-107", "expected a name as key, got a list or a mapping", self.begin(event)
            )
        self.stack.append(new)
        if len(self.stack) > MAX_DEPTH:
            self.fail("BT-103", TOO_DEEP, (new.place.line, new.place.column))
        if new.anchor is not None:
            self.anchors[new.anchor] = new

    def take_scalar(self, event: Any) -> None:
        top = self.stack[-1] if self.stack else None
        at = self.begin(event)
        if event.style in _QUOTES and event.anchor is None:  # a comment may follow an anchor
            self.quoted.append((event.start_mark.index, event.end_mark.index))
        if top is not None and isinstance(top.data, dict) and top.key is None:
            self.take_key(top, event, at)
            return
        text: str = event.value
        data = self.number_or_text(text, at) if _is_plain(event) else text
        is_single_line = isinstance(data, str) and event.start_mark.line == event.end_mark.line
        place = Place(*at, text=text if is_single_line else None)
        size = 1 + len(text) // TEXT_WEIGHT if isinstance(data, str) else 1
        if event.anchor is not None:
            self.anchors[event.anchor] = _Open(data, place, size=size, closed=True)
        self.add(data, place, size, 1)

    def take_key(self, top: _Open, event: Any, at: At) -> None:
        key: str = event.value
        if _is_plain(event) and not isinstance(self.number_or_text(key, at), str):
            got = "nothing" if key == "" else key
            self.note("BT-107", f"expected a name as key, got {got[:60]}", at, self.point_hint(*at))
        if key == "<<" and _is_plain(event):
            hint = "write the keys themselves here; YAML 1.2 has no merge keys"
            self.note("BT-108", "merge keys ('<<') are not allowed", at, hint)
        assert top.place.keys is not None
        if key in top.place.keys:
            first = top.place.keys[key][0]
            self.note("BT-106", f"duplicate key {quoted(key)} (first in line {first})", at)
        top.key, top.key_at = key, at

    def point_hint(self, line: int, column: int) -> str | None:
        """Return how a number is written that has a decimal comma before this place."""
        match = _DECIMAL_COMMA.search(self.lines[line - 1][: column + 20])
        if match is None or match.start(2) != column - 1:
            return None
        return f"decimals are written with a point: {match[1]}.{match[2]}"

    def take_alias(self, event: Any) -> None:
        at = _start(event)
        target = self.anchors.get(event.anchor)
        if target is None:
            self.fail("BT-108", f"this alias has no anchor '&{event.anchor}' before it", at)
            return
        if not target.closed:
            self.fail("BT-108", f"the alias '*{event.anchor}' contains itself", at)
        top = self.stack[-1] if self.stack else None
        if top is not None and isinstance(top.data, dict) and top.key is None:
            self.fail("BT-107", "expected a name as key, got an alias", at)
        if len(self.stack) + target.height > MAX_DEPTH:
            self.fail("BT-103", TOO_DEEP, at)
        self.add(target.data, target.place, target.size, target.height, at)

    def add(self, data: Any, place: Place, size: int, height: int, at: At | None = None) -> None:
        """Put a finished value where it belongs."""
        self.values += size if at else 1
        if self.values > MAX_VALUES:
            what = "with aliases expanded, " if at else ""
            message = f"{what}the file exceeds the limit of {MAX_VALUES:,} values"
            self.fail("BT-103", message, at or (place.line, place.column))
        if not self.stack:
            self.root = (data, place)
            return
        top = self.stack[-1]
        top.size += size
        top.height = max(top.height, height + 1)
        if isinstance(top.data, dict):
            assert top.key is not None
            assert top.place.keys is not None
            assert isinstance(top.place.parts, dict)
            top.data[top.key] = data
            top.place.keys[top.key] = top.key_at
            top.place.parts[top.key] = place
            top.key = None
        else:
            assert isinstance(top.place.parts, list)
            top.data.append(data)
            top.place.parts.append(place)

    def number_or_text(self, text: str, at: At) -> Any:
        """Return what a plain scalar means in the core schema of YAML 1.2."""
        if text[:1] not in _NUMBER_START:
            return _WORDS.get(text, text)
        if _NOT_FINITE.fullmatch(text):
            self.note("BT-304", f"expected a finite number, got {text}", at)
            return 0.0
        number: int | float
        if _INTEGER.fullmatch(text) or _PREFIXED.fullmatch(text):
            base = 10 if _INTEGER.fullmatch(text) else 0
            number = int(text, base) if len(text) <= 25 else MAX_INTEGER + 1
        elif _FLOAT.fullmatch(text):
            number = float(text)
        else:
            return text
        if (isinstance(number, int) and abs(number) > MAX_INTEGER) or math.isinf(number):
            self.note("BT-304", f"the number {quoted(text)} is too large", at)
            return 0
        return number
