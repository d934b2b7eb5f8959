"""Texts that attack whoever shows them, values that are full of such, and what shows a leak.

What is forbidden is told here once more, and not by the product's own function: a mistake in that
one is to be seen.
"""

from __future__ import annotations

import dataclasses
import re
import sys
import typing
import unicodedata
from collections.abc import Mapping
from html.parser import HTMLParser
from pathlib import Path
from types import NoneType, UnionType
from typing import Any

import numpy as np

from bt_mission.base import text
from bt_mission.base.text import is_shown

ATTACKS = {
    "clipboard": "\x1b]52;c;SEVJ\x07",
    "title": "\x1b]0;owned\x1b\\",
    "link": "\x1b]8;;http://evil.test\x1b\\here\x1b]8;;\x1b\\",
    "colour": "\x1b[1337;31m",
    "cursor": "\x1b[1337A\x1b[1337J",
    "device string": "\x1bP1337q\x1b\\",
    "C0": "".join(map(chr, (*range(10), *range(11, 32)))),
    "C1": "".join(map(chr, range(0x7F, 0xA0))),
    "direction": "\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069\u200e\u200f\u061c",
    "lines": "\u2028\u2029\x85",
    "zero width": "\u200b\u200c\u200d\u2060\ufeff\u00ad\u180e",
    "tags": "\U000e0001\U000e0041\U000e007f",
    "invisible letters": "\u034f\u115f\u1160\u3164\uffa0",
    "forged line": "\nFORGED line",
}
"""Each is valid UTF-8, so that any field of a message can hold it."""

MARKUP = "[reverse]m[/]<evil onevil=\"x\" a='>\" onevil='1' &#x202e;]]>--><evil/>$(evil)`evil`"
"""For Rich and Textual, HTML and XML, and shells. It is printable, so that names can hold it."""

MARK = "MARK"
SHORT = "\x1b]52;c;A\x07\x1b[1337m\x9b7m\u202e\u2066\u2028\u200b\U000e0041\u3164\x7f\x00"
"""The worst of it, for what is cut at the edge of a screen."""

HOSTILE = "".join((MARK, MARKUP, *ATTACKS.values()))
INVISIBLE = "\u034f\u115f\u1160\u17b4\u17b5\u180b\u180c\u180d\u180f\u3164\uffa0"

_CSI = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")
_OURS = re.compile(r"\x1b\[(?!1337)[0-9;?]*[A-Za-z]")


def leaks(output: str, *, is_coloured: bool = False) -> list[str]:
    """Name what is in an output that must not be: code points, and forged lines.

    Args:
        output: As it is written.
        is_coloured: It may hold control sequences that do not come from an attack, and what moves
            the cursor to the start of a line.
    """
    if is_coloured:
        output = _OURS.sub("", output).replace("\r", "")
    faults = {
        f"U+{ord(character):04X}"
        for character in set(output)
        if character != "\n"
        and (
            unicodedata.category(character) in ("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp")
            or character in INVISIBLE
            or "\U000e0000" <= character <= "\U000e0fff"
        )
    }
    if re.search("^FORGED", output, re.MULTILINE):
        faults.add("a forged line")
    return sorted(faults)


class _Elements(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.elements: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "evil" or any("evil" in name for name, _ in attrs):
            self.elements.append(f"an element: {tag} {attrs}")


def markup_leaks(page: str) -> list[str]:
    """Name what is in HTML, SVG or XML that must not be, elements of the attack among it.

    A line feed there is a blank.
    """
    elements = _Elements()
    elements.feed(page)
    return leaks(page.replace("\n", " ")) + elements.elements


# ---- values full of attacks ------------------------------------------------------------------


class _Names(dict[str, Any]):
    """Names of ours that a module imports for its annotations only."""

    def __missing__(self, name: str) -> Any:
        for module in list(sys.modules.values()):
            if module.__name__.startswith("bt_mission.") and hasattr(module, name):
                return getattr(module, name)
        raise KeyError(name)


def _hints(kind: Any) -> dict[str, Any]:
    try:
        return typing.get_type_hints(kind)
    except NameError:
        return typing.get_type_hints(kind, localns=_Names())


def filled(kind: Any, words: str = HOSTILE) -> Any:
    """Return a value of a type, each text in it hostile, however deep it lies.

    It walks annotations, so a field that is added later is filled, too.
    """
    if dataclasses.is_dataclass(kind):
        hints = _hints(kind)
        names = [field.name for field in dataclasses.fields(kind) if field.init]
        value: Any = kind
        return value(**{name: filled(hints[name], words) for name in names})
    if typing.get_args(kind):
        return _filled_generic(kind, words)
    simple = {str: words, Any: words, Path: Path(words.replace("\0", "")), bytes: b""}
    if kind in simple:
        return simple[kind]
    members = getattr(kind, "__members__", None)
    return next(iter(members.values())) if members else kind(1)


def _filled_generic(kind: Any, words: str) -> Any:
    origin, inner = typing.get_origin(kind), typing.get_args(kind)
    if origin in (typing.Union, UnionType):
        return filled(next(option for option in inner if option is not NoneType), words)
    if origin is typing.Literal:
        return inner[0]
    if origin is np.ndarray:
        return np.zeros(1)
    if origin is tuple:
        items = inner[:1] if inner[-1] is Ellipsis else inner
        return tuple(filled(member, words) for member in items)
    if issubclass(origin, Mapping):
        return {words: filled(inner[1], words)}
    return origin([filled(inner[0], words)])


def fill(message: Any, words: str = HOSTILE) -> Any:
    """Fill each text of a ROS message, and one item of each list of such; gives the message.

    It walks the fields of the type, so a field that is added later is filled, too.
    """
    for name, type_name in message.get_fields_and_field_types().items():
        value = getattr(message, name)
        if hasattr(value, "get_fields_and_field_types"):
            fill(value, words)
        elif type_name.startswith(("string", "wstring", "sequence<string", "sequence<wstring")):
            bound = re.search(r"<(\d+)>|, (\d+)>", type_name)
            shown = words[: int(bound[1] or bound[2])] if bound else words
            setattr(message, name, shown if isinstance(value, str) else [shown])
        elif type_name.startswith("sequence<") and "/" in type_name:
            setattr(message, name, [fill(item(type_name), words)])
    return message


def item(sequence: str) -> Any:
    """Return a new item of a list, from the name of its type: ``sequence<std_msgs/String>``."""
    package, name = re.findall(r"[\w/]+", sequence.removeprefix("sequence"))[0].split("/")
    module = __import__(f"{package}.msg", fromlist=[name])
    return getattr(module, name)()


def texts_in(value: Any) -> int:
    """Count the texts of a message that are hostile."""
    if isinstance(value, str):
        return MARK in value
    if hasattr(value, "get_fields_and_field_types"):
        names = value.get_fields_and_field_types()
        return sum(texts_in(getattr(value, name)) for name in names)
    return sum(map(texts_in, value)) if isinstance(value, list | tuple) else 0


# ---- a hole in everything --------------------------------------------------------------------


def escape_nothing(monkeypatch: Any) -> None:
    """Take escaping away, wherever it is called from: then each output has to leak."""
    monkeypatch.setattr(text, "_is_all_shown", lambda _: True)
    escaping = is_shown  # this module is among them, too
    for module in list(sys.modules.values()):
        if getattr(module, "is_shown", None) is escaping:
            monkeypatch.setattr(module, "is_shown", lambda _: True)
