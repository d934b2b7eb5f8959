"""A scene as SVG: one file without fonts or scripts."""

from __future__ import annotations

from collections.abc import Iterator

from bt_mission.base.text import escape_markup
from bt_mission.views.drawing.letters import width_px
from bt_mission.views.drawing.scene import FONT, PAPER, Polyline, Rectangle, Scene, Shape, Words


def svg(scene: Scene) -> str:
    """The whole file."""
    return "\n".join(_lines(scene)) + "\n"


def _lines(scene: Scene) -> Iterator[str]:
    width, height = _px(scene.width), _px(scene.height)
    yield (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        f'viewBox="0 0 {width} {height}" font-family="{FONT}" role="img">'
    )
    yield f"<title>{escape_markup(scene.title)}</title>"
    yield f'<rect width="{width}" height="{height}" fill="{PAPER}"/>'
    for shape in scene.shapes:
        yield _element(shape)
    yield "</svg>"


def _element(shape: Shape) -> str:
    match shape:
        case Rectangle():
            return (
                f'<rect x="{_px(shape.x)}" y="{_px(shape.y)}" width="{_px(shape.width)}" '
                f'height="{_px(shape.height)}" rx="{_px(shape.radius)}" fill="{shape.fill}" '
                f'stroke="{shape.stroke}" stroke-width="{_px(shape.thick)}"/>'
            )
        case Polyline():
            points = " ".join(f"{_px(x)},{_px(y)}" for x, y in shape.points)
            return (
                f'<polyline points="{points}" fill="none" stroke="{shape.stroke}" '
                f'stroke-width="{_px(shape.thick)}"/>'
            )
        case Words():
            return _words(shape)


def _words(shape: Words) -> str:
    weight = ' font-weight="bold"' if shape.bold else ""
    anchor = ' text-anchor="middle"' if shape.centred else ""
    # Another font is stretched to the width of the box.
    room = width_px(shape.text, shape.size, bold=shape.bold)
    fit = "" if shape.centred else f' textLength="{_px(room)}" lengthAdjust="spacingAndGlyphs"'
    return (
        f'<text x="{_px(shape.x)}" y="{_px(shape.y)}" font-size="{_px(shape.size)}" '
        f'fill="{shape.fill}"{weight}{anchor}{fit}>{escape_markup(shape.text)}</text>'
    )


def _px(value: float) -> str:
    return f"{value:.1f}".removesuffix(".0")
