"""XML as elements: read with places, a document type refused, and written for people to read.

The parser is expat; no entity but the five of XML itself is ever expanded. The standard library's
writers put all attributes of an element on one line, however long; this one breaks such lines.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NoReturn
from xml.parsers import expat

from bt_mission.base.diagnostics import InputError, diagnostic_at, quoted
from bt_mission.base.text import is_shown
from bt_mission.base.yaml.composer import At
from bt_mission.base.yaml.document import refuse_large

MAX_DEPTH = 100
"""Elements within each other."""

WIDTH = 100
"""Characters of a line that is written."""

_BREAK = re.compile("\r\n|\n|\r")
_ATTRIBUTE = re.compile(r"""\s+([^\s=/>]+)\s*=\s*("[^"]*"|'[^']*')""")
_CHARACTER = re.compile(r"&[^;]*;|.", re.DOTALL)
_UNQUOTED = re.compile(r"""([^\s<>"'=/]+)\s*=\s*x\Z""")
"""The name of an attribute whose value, at the end, has no quotes."""
_UTF_8 = frozenset(("utf-8", "utf8", "us-ascii", "ascii"))
_ESCAPES = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;"})
_MESSAGES = {
    "no element found": "the text ends before the first element",
    "junk after document element": "content after the end of the root element",
    "not well-formed (invalid token)": "invalid XML",
    "XML or text declaration not at start of entity": "'<?xml' is allowed only at the very start",
    "unclosed token": "this tag, text or comment is never closed",
    "undefined entity": "an undefined entity",
}


@dataclass(frozen=True, slots=True)
class Attribute:
    """An attribute: its value, where its name stands, and where the quote before its value."""

    name: str
    value: str
    at: At
    value_at: At
    raw: str = ""

    def within(self, offset: int) -> At:
        """Return where a character of the value stands (from 0), as it is written in the file."""
        written = 0
        for count, match in enumerate(_CHARACTER.finditer(self.raw)):
            if count == offset or match.group() in "\r\n":
                break
            written = match.end()
        return self.value_at[0], self.value_at[1] + 1 + written


@dataclass(slots=True)
class Element:
    """An element, with the place of its name."""

    tag: str
    at: At
    attributes: dict[str, Attribute] = field(default_factory=dict)
    children: list[Element] = field(default_factory=list)
    text: str = ""
    text_at: At = (0, 0)


@dataclass(frozen=True)
class XmlSource:
    """An XML file: its root element and its lines."""

    file: str
    root: Element
    lines: tuple[str, ...]


def parse(text: str, file: str) -> XmlSource:
    """Return the elements of an XML text. Raises InputError with the first diagnostic."""
    refuse_large(text, file)
    return _XmlParser(text, file).parse()


class _XmlParser:
    def __init__(self, text: str, file: str) -> None:
        self._text = text
        self._file = file
        self._lines = tuple(_BREAK.split(text))
        self._starts = [0, *(line_break.end() for line_break in _BREAK.finditer(text))]
        self._bytes = text.encode("utf-8", "replace")
        self._last = (0, 0)  # bytes and characters up to the last place that was looked for
        self._stack: list[Element] = []
        self._root: Element | None = None
        parser: Any = expat.ParserCreate("utf-8")
        parser.ordered_attributes = True
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._characters
        parser.StartDoctypeDeclHandler = self._doctype
        parser.XmlDeclHandler = self._declaration
        self._parser = parser

    def parse(self) -> XmlSource:
        try:
            self._parser.Parse(self._bytes, True)
        except expat.ExpatError as error:
            self._fail("BT-1201", *self._explain(expat.ErrorString(error.code) or "", error))
        assert self._root is not None, "the parser refuses text without an element"
        return XmlSource(self._file, self._root, self._lines)

    def _explain(self, problem: str, error: Any) -> tuple[str, At, str | None]:
        offset = self._offset(min(max(self._parser.ErrorByteIndex, 0), len(self._bytes)))
        at = self._place(offset)
        if problem in ("mismatched tag", "no element found") and self._stack:
            top = self._stack[-1]
            message = f"<{top.tag}> of line {top.at[0]} is not closed here"
            return message, at, f"expected '</{top.tag}>'"
        if problem == "not well-formed (invalid token)":
            character = self._text[offset : offset + 1]
            named = (
                f"{_MESSAGES[problem]}: unexpected {quoted(character)}"
                if character
                else _MESSAGES[problem]
            )
            return named, at, self._token_hint(offset)
        return _MESSAGES.get(problem, f"invalid XML: {problem or error}"), at, None

    def _token_hint(self, offset: int) -> str | None:
        """Return what to write where the parser stops, at a character that it does not expect."""
        if match := _UNQUOTED.search(self._text[:offset] + "x"):
            return f'put the value in quotes: {match[1]}="..."'
        if set(self._text[max(offset - 1, 0) : offset + 1]) & {"&", "<"}:
            return "write '&amp;' for '&' and '&lt;' for '<' in text"
        if self._text[offset : offset + 1] == ",":
            return "separate attributes by spaces"
        return None

    def _start(self, tag: str, flat: list[str]) -> None:
        offset = self._offset(self._parser.CurrentByteIndex)
        element = Element(tag, self._place(offset + 1))
        if len(self._stack) >= MAX_DEPTH:
            message = f"nested too deeply; the limit is {MAX_DEPTH} levels"
            self._fail("BT-103", message, element.at)
        values = dict(zip(flat[::2], flat[1::2], strict=True))
        at = offset + 1 + len(tag)
        while match := _ATTRIBUTE.match(self._text, at):
            name = match[1]
            places = self._place(match.start(1)), self._place(match.start(2))
            element.attributes[name] = Attribute(name, values[name], *places, raw=match[2][1:-1])
            at = match.end()
        if self._stack:
            self._stack[-1].children.append(element)
        else:
            self._root = element
        self._stack.append(element)

    def _end(self, _tag: str) -> None:
        element = self._stack.pop()
        element.text = element.text.strip()

    def _characters(self, text: str) -> None:
        top = self._stack[-1]
        if text.strip() and not top.text.strip():
            offset = self._offset(self._parser.CurrentByteIndex)
            top.text_at = self._place(offset + len(text) - len(text.lstrip()))
        top.text += text

    def _doctype(self, name: str, *_: Any) -> None:
        offset = self._offset(self._parser.CurrentByteIndex)
        message = f"a document type ({quoted(name)}) is not allowed"
        self._fail("BT-1201", message, self._place(offset), "remove '<!DOCTYPE ...>'")

    def _declaration(self, _version: str, encoding: str | None, _standalone: int) -> None:
        if encoding is not None and encoding.lower() not in _UTF_8:
            message = f"expected text in UTF-8, got the encoding {quoted(encoding)}"
            self._fail("BT-102", message, (1, 1), "save the file as UTF-8")

    def _offset(self, byte: int) -> int:
        """Return the characters before a byte. Places are asked for in the order of the file."""
        if len(self._bytes) == len(self._text):
            return byte
        known, offset = self._last if self._last[0] <= byte else (0, 0)
        offset += len(self._bytes[known:byte].decode("utf-8", "replace"))
        self._last = (byte, offset)
        return offset

    def _place(self, offset: int) -> At:
        line = bisect_right(self._starts, offset)
        return line, offset - self._starts[line - 1] + 1

    def _fail(self, code: str, message: str, at: At, hint: str | None = None) -> NoReturn:
        raise InputError(
            [diagnostic_at(code, at, self._file, self._lines, message, hint)]
        ) from None


@dataclass(frozen=True)
class Tag:
    """An element to be written."""

    name: str
    attributes: Mapping[str, str] = field(default_factory=dict)
    children: tuple[Tag, ...] = ()

    def walk(self) -> Iterator[Tag]:
        """Yield this element and all below it, in the order of the file."""
        yield self
        for child in self.children:
            yield from child.walk()


def xml_text(root: Tag) -> str:
    """Return an XML file with this root."""
    return "\n".join(['<?xml version="1.0" encoding="UTF-8"?>', *_tag_lines(root, "")]) + "\n"


def _tag_lines(tag: Tag, pad: str) -> Iterator[str]:
    end = ">" if tag.children else "/>"
    attributes = [f'{name}="{_escaped(value)}"' for name, value in tag.attributes.items()]
    line = " ".join([f"{pad}<{tag.name}", *attributes]) + end
    if len(line) <= WIDTH or len(attributes) < 2:
        yield line
    else:
        yield f"{pad}<{tag.name}"
        yield from (f"{pad}    {attribute}" for attribute in attributes[:-1])
        yield f"{pad}    {attributes[-1]}{end}"
    for child in tag.children:
        yield from _tag_lines(child, f"{pad}  ")
    if tag.children:
        yield f"{pad}</{tag.name}>"


def _escaped(value: str) -> str:
    """Return the value of an attribute, with references for what does not show as itself."""
    text = value.translate(_ESCAPES)
    return "".join(
        character if is_shown(character) else f"&#{ord(character)};" for character in text
    )
