"""Markup that several parts of the page share."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence

from bt_mission.core.text import escape_markup
from bt_mission.views.html_report.markup import element


def line(cells: Iterable[str], names: Sequence[str] = (), **attributes: object) -> str:
    """Return a row of a table, of cells that are markup already."""
    padded = [*names, *[""] * 20]
    return element(
        "tr",
        "".join(
            element("td", cell, class_=name or None)
            for cell, name in zip(cells, padded, strict=False)
        ),
        **attributes,
    )


def command_line(command: str) -> str:
    """Return a command that can be copied as a whole."""
    try:
        split = shlex.split(command)
    except ValueError:  # a quotation mark without another: no line that a shell would take
        split = [command]
    words = (
        element("span", escape_markup(shlex.quote(word) if word != "&&" else word), class_="word")
        for word in split
    )
    return element("code", " ".join(words), class_="command")
