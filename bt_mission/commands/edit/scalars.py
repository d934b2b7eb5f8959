"""Texts as scalars of YAML, with quotes only where they need them."""

from __future__ import annotations

from bt_mission.base.diagnostics import InputError
from bt_mission.base.text import is_shown
from bt_mission.base.yaml.composer import compose
from bt_mission.commands.edit.spans import read_spans


def as_text(text: str) -> str:
    """Return a text as a YAML scalar, with quotes only if it needs them."""
    if not all(map(is_shown, text)):
        return _double_quoted(text)
    for written in (text, "'" + text.replace("'", "''") + "'"):
        if written != written.strip():
            continue
        try:
            span = read_spans(f"[{written}]")
        except InputError:
            continue
        only = span.items[0] if len(span.items) == 1 else None
        if only is not None and only.kind == "scalar" and only.text == text:
            is_word = written is text and not _is_text(text)
            if not is_word:
                return written
    return _double_quoted(text)


def _is_text(text: str) -> bool:
    """Return whether YAML reads a plain scalar as a text."""
    try:
        return isinstance(compose(f"[{text}]", "<text>")[0][0], str)
    except InputError:
        return False


def _double_quoted(text: str) -> str:
    escapes = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\t": "\\t"}
    shown = (
        escapes.get(char) or (char if is_shown(char) else f"\\U{ord(char):08x}") for char in text
    )
    return f'"{"".join(shown)}"'
