r"""Text of others on its way out: the one place that decides what is written as an escape.

A terminal obeys control sequences; marks of the direction of writing and characters that cannot be
seen make a text look like another one. :func:`escape_control` writes all of them as Python would:
``\x1b``, ``\u202e``. Each kind of output has one border that calls it:

- standard output and error: :mod:`bt_mission.views.terminal.streams`
- Rich: :mod:`bt_mission.views.terminal.console`; Textual: :mod:`bt_mission.views.terminal.screen`
- logs of ROS nodes: :mod:`bt_mission.base.ros_log`
- HTML and SVG: :func:`escape_markup`, and :func:`escape_page` for a whole page in a frame
- XML and YAML, which keep every value, write references and escapes of their own for what is not
  :func:`is_shown`

JSON needs none: ``json.dumps`` writes ASCII.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Sequence

_INVISIBLE = re.compile(
    "[\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180d\u180f\u3164\uffa0\U000e0100-\U000e01ef]"
)
"""Letters and marks that show nothing; other invisible characters are known by their category."""

_COLOUR = re.compile("(\x1b\\[(?:(?:0?[0-79]|[1-9][0-9]|10[0-7])(?:;(?!m)|(?=m)))*m)")
"""Colours and weights, but not the one that hides text."""

_NAMED = {"\n": "\\n", "\t": "\\t", "\r": "\\r"}


def escape_control(text: str) -> str:
    """Return the text on one line, with what could command a terminal or deceive escaped.

    Escaping an escaped text changes nothing.
    """
    if _is_all_shown(text):
        return text
    return "".join(character if is_shown(character) else _escape(character) for character in text)


def escape_lines(text: str) -> str:
    """Return a text of several lines, escaped as by :func:`escape_control`; line feeds stay."""
    if _is_all_shown(text):
        return text
    return "\n".join(map(escape_control, text.split("\n")))


def lines_of(text: str) -> list[str]:
    """Return the lines of a text that is shown: a line feed ends one, and nothing else does.

    `str.splitlines` also takes characters for it that come from others, and are escaped later.
    """
    return text.removesuffix("\n").split("\n") if text else []


def escape_uncoloured(line: str) -> str:
    """Return a line that another program has coloured, escaped but for its colours."""
    pieces = _COLOUR.split(line)
    pieces[::2] = map(escape_control, pieces[::2])
    return "".join(pieces)


def escape_markup(text: str) -> str:
    """Return a text as the content, or the value of an attribute, of an HTML or SVG element."""
    import html  # noqa: PLC0415 - for pages alone

    return html.escape(escape_lines(text))


def escape_page(page: str) -> str:
    """Return a whole page as the value of a frame's ``srcdoc``; its texts are escaped already."""
    import html  # noqa: PLC0415 - for pages alone

    return html.escape(page)


def category(character: str) -> str:
    """Return the general category of a character, such as "Lu" (Unicode Standard, section 4.5)."""
    return unicodedata.category(character)


def is_shown(character: str) -> bool:
    """Return whether a character shows as itself, or as a blank, without an effect."""
    if character.isprintable():
        return not _INVISIBLE.match(character)
    return category(character) == "Zs"


def _is_all_shown(text: str) -> bool:
    return text.isprintable() and (text.isascii() or not _INVISIBLE.search(text))


def _escape(character: str) -> str:
    code = ord(character)
    if code < 0x100:
        return _NAMED.get(character, f"\\x{code:02x}")
    return f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def cut(text: str, most: int) -> str:
    """Return a text of at most `most` characters; ``…`` replaces the rest."""
    return text if len(text) <= most else f"{text[: most - 1]}…"


def can_encode(text: str, encoding: str | None) -> bool:
    """Return whether a stream of this encoding can show a text; None is ASCII."""
    try:
        text.encode(encoding or "ascii")
    except (UnicodeEncodeError, LookupError):
        return False
    return True


def columns(rows: Iterable[Sequence[str]]) -> list[str]:
    """Return rows of cells as escaped lines, the cells of a column aligned."""
    table = [tuple(escape_control(cell) for cell in row) for row in rows]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    return [
        "  ".join(f"{cell:{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in table
    ]


def counted(count: int, noun: str) -> str:
    """Return a count with its noun, in the plural unless it is one."""
    return f"{count:,} {noun}" if count == 1 else f"{count:,} {noun}s"


def number(value: float, digits: int = 3) -> str:
    """Return a number with at most as many decimals as given, and no more than needed."""
    text = f"{value:.{digits}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text == "-0" else text


def seconds(value_s: float) -> str:
    """Return a time of a run, as every view of it shows times: ``125.30 s``."""
    return f"{value_s:.2f} s"


def duration(value_s: float) -> str:
    """Return an estimate in a suitable unit: ``42 s``, ``3 min``, ``2 h 10 min``, ``3.5 days``."""
    if value_s < 100:
        return f"{value_s:.0f} s"
    minutes = round(value_s / 60)
    if minutes < 100:
        return f"{minutes} min"
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours < 48 else f"{hours / 24:.1f} days"
