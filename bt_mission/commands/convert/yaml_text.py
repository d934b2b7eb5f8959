"""Data as the text of a YAML file, in the way that people write missions."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any

from bt_mission.base.text import is_shown

WIDTH = 100
_PLAIN = re.compile(r"[A-Za-z_/$][A-Za-z0-9_ ./$()<>=*+-]*(?<! )")
_LINE = re.compile(r"[A-Za-z_/$][A-Za-z0-9_ ./$()<>=*+,;!?%'-]*(?<! )")
_WORDS = frozenset(
    word.lower() for word in ("true", "false", "null", "yes", "no", "on", "off", "y", "n")
)
_BLOCKS = frozenset(("sequence", "fallback", "parallel", "do", "else", "invert", "tree", "trees"))


def yaml_text(data: dict[str, Any]) -> str:
    """Return a mission's data as a text that is read as the same data."""
    lines: list[str] = []
    for key, value in data.items():
        if key in ("inputs", "trees", "tree") and lines:
            lines.append("")
        lines += _entry(key, value, 0)
    return "\n".join(lines) + "\n"


def flow(value: Any) -> str:
    """Return a value on one line."""
    match value:
        case bool():
            return "true" if value else "false"
        case int() | float():
            return repr(value)
        case str():
            return _scalar(value)
        case dict():
            return (
                "{"
                + ", ".join(f"{_scalar(key)}: {flow(item)}" for key, item in value.items())
                + "}"
            )
        case _:
            return "[" + ", ".join(flow(item) for item in value) + "]"


def escaped(text: str, escape: Callable[[str], str]) -> str:
    """Return a text in double quotes, quotes, backslashes and what cannot be shown escaped."""
    inner = "".join(f"\\{c}" if c in '"\\' else c if is_shown(c) else escape(c) for c in text)
    return f'"{inner}"'


def _scalar(text: str) -> str:
    if _PLAIN.fullmatch(text) and text.lower() not in _WORDS:
        return text
    if all(map(is_shown, text)) and "'" not in text:
        return f"'{text}'"
    return escaped(text, lambda c: f"\\U{ord(c):08X}")


def _entry(key: str, value: Any, indent: int) -> list[str]:
    """Return the lines of a key and its value."""
    pad, head = " " * indent, f"{_scalar(key)}:"
    is_line = isinstance(value, str) and _LINE.fullmatch(value) and value.lower() not in _WORDS
    line = f"{pad}{head} {value if is_line else flow(value)}"
    is_collection = isinstance(value, dict | list) and bool(value)
    if not is_collection or (not _has_block(key, value) and len(line) <= WIDTH):
        return [line]
    if isinstance(value, dict):
        return [f"{pad}{head}", *_mapping(value, indent + 2)]
    return [f"{pad}{head}", *(line for item in value for line in _item(item, indent + 2))]


def _mapping(value: dict[str, Any], indent: int) -> list[str]:
    return [line for key, item in value.items() for line in _entry(key, item, indent)]


def _item(value: Any, indent: int) -> Iterator[str]:
    """Yield the lines of an item of a list."""
    pad = " " * indent
    if not isinstance(value, dict) or not value:
        yield f"{pad}- {flow(value)}"
        return
    first, *rest = _mapping(value, indent + 2)
    yield f"{pad}- {first.lstrip(' ')}"
    yield from rest


def _has_block(key: str, value: Any) -> bool:
    """Return whether nodes stand in a value, or several entries that are read more easily so."""
    if key in _BLOCKS and isinstance(value, list):
        return True
    if isinstance(value, dict):
        nodes = key in _BLOCKS and (len(value) > 1 or key == "trees")
        return nodes or any(_has_block(inner, item) for inner, item in value.items())
    return False
