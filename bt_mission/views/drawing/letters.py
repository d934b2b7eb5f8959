"""The width of a text, without its font.

Figures are the advances of DejaVu Sans in thousandths of its size. Verdana is as wide, and the
other fonts of browsers are narrower, so that no text leaves its box.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator

from bt_mission.base.text import escape_control

FIRST = 32
# fmt: off
REGULAR = (
    318, 401, 460, 838, 636, 950, 780, 275, 390, 390, 500, 838, 318, 361, 318, 337, 636, 636, 636,
    636, 636, 636, 636, 636, 636, 636, 337, 337, 838, 838, 838, 531, 1000, 684, 686, 698, 770, 632,
    575, 775, 752, 295, 295, 656, 557, 863, 748, 787, 603, 787, 695, 635, 611, 732, 684, 989, 685,
    611, 685, 390, 337, 390, 838, 500, 500, 613, 635, 550, 635, 615, 352, 635, 634, 278, 278, 579,
    278, 974, 634, 612, 635, 635, 411, 521, 392, 634, 592, 818, 592, 592, 525, 636, 337, 636, 838,
)
BOLD = (
    348, 456, 521, 838, 696, 1002, 872, 306, 457, 457, 523, 838, 380, 415, 380, 365, 696, 696, 696,
    696, 696, 696, 696, 696, 696, 696, 400, 400, 838, 838, 838, 580, 1000, 774, 762, 734, 830, 683,
    683, 821, 837, 372, 372, 775, 637, 995, 837, 850, 733, 850, 770, 720, 682, 812, 774, 1103, 771,
    724, 725, 457, 365, 457, 838, 500, 500, 675, 716, 593, 716, 678, 435, 716, 712, 343, 343, 665,
    343, 1042, 712, 687, 716, 716, 493, 595, 478, 712, 652, 924, 645, 652, 582, 712, 365, 712, 838,
)
# fmt: on
OTHER = 750
WIDE = 1000


def width_px(text: str, size_px: float, *, bold: bool = False) -> float:
    """Return the width of a text on one line, px."""
    table = BOLD if bold else REGULAR
    return sum(_advance(letter, table) for letter in text) * size_px / 1000


def wrapped(text: str, size_px: float, room_px: float) -> Iterator[str]:
    """Return the lines of a text for a width, escaped; words that are too long are cut."""
    line = ""
    for word in map(escape_control, text.split()):
        candidate = f"{line} {word}" if line else word
        if width_px(candidate, size_px) <= room_px:
            line = candidate
            continue
        if line:
            yield line
        line = word
        while width_px(line, size_px) > room_px:
            fits = _fitting(line, size_px, room_px)
            yield line[:fits]
            line = line[fits:]
    if line:
        yield line


def _fitting(text: str, size_px: float, room_px: float) -> int:
    """Return how many of the first letters fit; at least one."""
    count = 1
    while width_px(text[: count + 1], size_px) <= room_px:
        count += 1
    return count


def _advance(letter: str, table: tuple[int, ...]) -> int:
    index = ord(letter) - FIRST
    if 0 <= index < len(table):
        return table[index]
    if letter == "\N{NO-BREAK SPACE}":
        return table[0]
    if unicodedata.combining(letter):
        return 0
    return WIDE if unicodedata.east_asian_width(letter) in "WF" else OTHER
