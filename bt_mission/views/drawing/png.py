"""A scene as PNG, through Pillow."""

from __future__ import annotations

import io
from functools import cache
from typing import Any

from PIL import Image, ImageDraw, ImageFont

from bt_mission.base.errors import BtMissionError
from bt_mission.views.drawing.letters import width_px
from bt_mission.views.drawing.scene import PAPER, Polyline, Rectangle, Scene, Shape, Words

SCALE = 2
"""Pixels of the image for one of the scene: sharp on high-resolution screens."""

SMOOTH = 2
"""It is drawn larger by this factor and then scaled down, which smooths lines."""

MOST_PIXELS = 60_000_000
"""Of the drawing before it is scaled down: 180 MB."""

FONTS = {False: ("DejaVuSans.ttf",), True: ("DejaVuSans-Bold.ttf",)}


def png(scene: Scene) -> bytes:
    """The whole file. Raises BtMissionError where it would be too large."""
    factor = SCALE * SMOOTH
    width, height = round(scene.width * factor), round(scene.height * factor)
    if width * height > MOST_PIXELS:
        raise BtMissionError(
            f"the tree is too large for a PNG ({width // SMOOTH} x {height // SMOOTH} pixels); "
            "draw it as SVG",
            code="BT-1103",
        )
    image = Image.new("RGB", (width, height), PAPER)
    draw = ImageDraw.Draw(image)
    for shape in scene.shapes:
        _draw(draw, shape, factor)
    image = image.resize((width // SMOOTH, height // SMOOTH), Image.Resampling.LANCZOS)
    stream = io.BytesIO()
    image.quantize(256).save(stream, "PNG", optimize=True)
    return stream.getvalue()


def _draw(draw: Any, shape: Shape, factor: int) -> None:
    match shape:
        case Rectangle():
            corners = (shape.x, shape.y, shape.x + shape.width, shape.y + shape.height)
            draw.rounded_rectangle(
                [part * factor for part in corners],
                radius=min(shape.radius, shape.height / 2) * factor,
                fill=shape.fill,
                outline=shape.stroke,
                width=round(shape.thick * factor),
            )
        case Polyline():
            points = [(x * factor, y * factor) for x, y in shape.points]
            draw.line(points, fill=shape.stroke, width=round(shape.thick * factor), joint="curve")
        case Words():
            _write(draw, shape, factor)


def _write(draw: Any, words: Words, factor: int) -> None:
    face = font(round(words.size * factor), bold=words.bold)
    room = width_px(words.text, words.size, bold=words.bold) * factor
    if draw.textlength(words.text, font=face) > room * 1.05:
        face = font(round(words.size * factor * 0.85), bold=words.bold)
    anchor = "ms" if words.centred else "ls"
    place = words.x * factor, words.y * factor
    draw.text(place, words.text, fill=words.fill, font=face, anchor=anchor)


@cache
def font(size: int, *, bold: bool) -> Any:
    """Return a font of this machine, or the one of Pillow."""
    for name in FONTS[bold]:
        try:
            return ImageFont.truetype(name, size)
        except OSError:
            continue
    return ImageFont.load_default(size)
