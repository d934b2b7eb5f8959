"""Text of others on the way to a terminal."""

from __future__ import annotations

import unicodedata


def escape_control(text: str) -> str:
    """The text on one line, with everything that a terminal might obey written as an escape."""
    if text.isprintable():
        return text
    return "".join(_escaped(character) for character in text)


def _escaped(character: str) -> str:
    if character.isprintable() or unicodedata.category(character) in ("Zs", "Mn", "Mc"):
        return character
    code = ord(character)
    simple = {"\n": "\\n", "\t": "\\t", "\r": "\\r"}.get(character)
    return simple or (f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}")


def can_encode(text: str, encoding: str | None) -> bool:
    """Return whether a stream of this encoding can show a text; None is ASCII."""
    try:
        text.encode(encoding or "ascii")
    except (UnicodeEncodeError, LookupError):
        return False
    return True
