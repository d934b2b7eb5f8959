"""The captions beside the images: the mission, its time, what it does, and its result."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PIL import Image as Pillow
from PIL import ImageDraw

from bt_mission.base.text import escape_control, seconds
from bt_mission.base.verdicts import FAILING
from bt_mission.commands.video.mp4 import Picture
from bt_mission.executive.behaviours.leaves import LeafProgress
from bt_mission.views.drawing.letters import width_px, wrapped
from bt_mission.views.drawing.png import font

GROUND, INK, FAINT, BAR, EMPTY = "#12171d", "#f2f4f6", "#9aa5b1", "#3d8bfd", "#2a333d"
STATES = {
    "running": "#1f6feb",
    "paused": "#8a6d1d",
    "ending": "#8a6d1d",
    "observing": "#8a6d1d",
    "success": "#1a7f37",
    "failure": "#c5221f",
    "interrupted": "#b35c00",
    **dict.fromkeys(FAILING, "#c5221f"),
}
OVER = {"success", "failure", "interrupted", *FAILING}
MARGIN = 24
LEAVES = 4
REASON_LINES = 3


@dataclass(frozen=True)
class PanelLeaf:
    """A running leaf, and its progress."""

    name: str
    progress: LeafProgress | None = None


@dataclass(frozen=True)
class Captions:
    """The captions at one instant.

    Args:
        seconds: Virtual time since the start.
        state: The state of the mission in a word; the last ones are outcomes.
        leaves: The running leaves.
        log_line: The last line of the mission's log.
        reason: The reason of its end.
        facts: The result so far, in a line.
    """

    mission: str
    seconds: float
    state: str
    leaves: tuple[PanelLeaf, ...] = ()
    log_line: str = ""
    reason: str = ""
    facts: str = ""


def panel(captions: Captions, width: int, height: int) -> Picture:
    """Draw the captions: 8-bit RGB, `height` x `width` x 3."""
    image = Pillow.new("RGB", (width, height), GROUND)
    draw = ImageDraw.Draw(image)
    right, room = width - MARGIN, width - 2 * MARGIN
    clock = seconds(captions.seconds)
    draw.text((right, 44), clock, fill=INK, font=font(26, bold=True), anchor="rs")
    name = _fitting(captions.mission, 26, room - 120, bold=True)
    draw.text((MARGIN, 44), name, fill=INK, font=font(26, bold=True), anchor="ls")
    word = escape_control(captions.state).upper()
    colour = STATES.get(captions.state, EMPTY)
    is_over = captions.state in OVER
    size = 24 if is_over else 15
    wide = width_px(word, size, bold=True) + size * 1.4
    draw.rounded_rectangle((MARGIN, 62, MARGIN + wide, 62 + size * 1.7), size * 0.5, fill=colour)
    draw.text(
        (MARGIN + wide / 2, 62 + size * 0.85),
        word,
        fill="white",
        font=font(size, bold=True),
        anchor="mm",
    )
    y = 62 + size * 1.7 + 34
    for line in list(wrapped(captions.reason, 17, room))[:REASON_LINES]:
        draw.text((MARGIN, y), line, fill=INK, font=font(17, bold=False), anchor="ls")
        y += 25
    for leaf in captions.leaves[:LEAVES]:
        _draw_leaf(draw, leaf, y, room)
        y += 42
    if len(captions.leaves) > LEAVES:
        more = f"and {len(captions.leaves) - LEAVES} more"
        draw.text((MARGIN, y), more, fill=FAINT, font=font(15, bold=False), anchor="ls")
    for words, low in ((captions.log_line, 46), (captions.facts, 20)):
        line = _fitting(words, 15, room)
        draw.text((MARGIN, height - low), line, fill=FAINT, font=font(15, bold=False), anchor="ls")
    return np.asarray(image)


def _draw_leaf(draw: ImageDraw.ImageDraw, leaf: PanelLeaf, y: float, room: int) -> None:
    name = _fitting(leaf.name, 18, room - (180 if leaf.progress else 0))
    draw.text((MARGIN, y), name, fill=INK, font=font(18, bold=False), anchor="ls")
    progress = leaf.progress
    if progress is None:
        return
    unit = " s" if progress.label == "s" else ""
    words = f"{progress.value:.3g} of {progress.limit:.3g}{unit}"
    draw.text((MARGIN + room, y), words, fill=FAINT, font=font(16, bold=False), anchor="rs")
    share = progress.value / progress.limit if progress.limit > 0 else 1.0
    full = room * min(max(share, 0.0), 1.0)
    draw.rounded_rectangle((MARGIN, y + 7, MARGIN + room, y + 13), 3, fill=EMPTY)
    if full >= 6:
        draw.rounded_rectangle((MARGIN, y + 7, MARGIN + full, y + 13), 3, fill=BAR)


def _fitting(text: str, size: int, room: float, *, bold: bool = False) -> str:
    """Return as much of a text as fits on one line."""
    text = " ".join(map(escape_control, text.split()))
    if width_px(text, size, bold=bold) <= room:
        return text
    while text and width_px(text + "...", size, bold=bold) > room:
        text = text[:-1]
    return text + "..."
