"""Colours of worlds: a short list of names, or `#rrggbb`."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator

from bt_mission.base.diagnostics import did_you_mean, listed

NAMES = {
    "black": "#202020",
    "blue": "#1f4fe0",
    "brown": "#8a5a33",
    "green": "#1f9d3a",
    "grey": "#9aa0a6",
    "orange": "#f08a1d",
    "purple": "#8a3fc0",
    "red": "#d6202a",
    "turquoise": "#19c5c9",
    "white": "#f0f0ec",
    "yellow": "#f2cf1d",
}

_HEX = re.compile("#[0-9a-fA-F]{6}")

Rgba = tuple[float, float, float, float]


def rgba(colour: str) -> Rgba:
    """Return red, green, blue and alpha, 0 to 1. Raises ValueError with the names that are known.

    >>> rgba("#ff0000")
    (1.0, 0.0, 0.0, 1.0)
    """
    digits = NAMES.get(colour, colour)
    if not _HEX.fullmatch(digits):
        near = did_you_mean(colour, NAMES)
        raise ValueError(
            f"no such colour '{colour[:40]}' (known: {listed(NAMES)}, or '#rrggbb')"
            + (f"; {near}" if near else "")
        )
    red, green, blue = bytes.fromhex(digits[1:])
    return red / 255, green / 255, blue / 255, 1.0


def _known(colour: str) -> str:
    rgba(colour)
    return colour


Colour = Annotated[str, AfterValidator(_known)]
