"""The signs of a watcher's view, for terminals with UTF-8 and for those without."""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass

from py_trees.common import Status

from bt_mission.events.status_marks import ASCII, UNICODE, glyphs_for

PLACES = "123456789abcdefghijklmnopqrstuvwxyz"
"""Signs of waypoints on the map, in order."""


@dataclass(frozen=True)
class Marks:
    """Signs that an output can show.

    Args:
        arrows: Of the robot, from east on and anticlockwise; four or eight.
        wall: Of the upper half of a cell, the lower, and the whole.
    """

    status: Mapping[Status, str]
    full: str
    empty: str
    cursor: str
    breakpoint: str
    then: str
    rule: str
    wall: tuple[str, str, str]
    unknown: str
    trail: str
    scan: str
    arrows: str
    cut: str
    is_ascii: bool


SIGNS = Marks(
    UNICODE,
    full="█",
    empty="░",
    cursor="»",
    breakpoint="●",
    then=" ▸ ",
    rule="─",
    wall=("▀", "▄", "█"),
    unknown="░",
    trail="·",
    scan="∙",
    arrows="→↗↑↖←↙↓↘",
    cut="…",
    is_ascii=False,
)
ASCII_SIGNS = Marks(
    ASCII,
    full="#",
    empty=".",
    cursor=">",
    breakpoint="*",
    then=" > ",
    rule="-",
    wall=("#", "#", "#"),
    unknown=":",
    trail=".",
    scan="+",
    arrows=">^<v",
    cut="~",
    is_ascii=True,
)


def marks_for(encoding: str | None) -> Marks:
    """The signs that a stream of this encoding can show."""
    return SIGNS if glyphs_for(encoding) is UNICODE else ASCII_SIGNS


def clean(text: str, marks: Marks) -> str:
    """A text from elsewhere on one line, without what would move a terminal's cursor.

    Control characters, and those that turn the direction of writing, are shown as their code.
    """
    if text.isascii() and text.isprintable():
        return text
    shown = "".join(one if _is_harmless(one) else f"<{ord(one):02x}>" for one in text)
    return shown.encode("ascii", "replace").decode() if marks.is_ascii else shown


def _is_harmless(character: str) -> bool:
    return unicodedata.category(character)[0] != "C" and character not in "\u2028\u2029"
