"""The shapes and colours of worlds: upright boxes and cylinders, names of colours or `#rrggbb`."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from typing import Annotated, Literal

from pydantic import AfterValidator

from bt_mission.base.diagnostics import did_you_mean, listed
from sim.world.motion import Motion

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


@dataclass(frozen=True)
class Obstacle:
    """Something on the floor: centre (m), direction (rad), edges along its own x, y and z (m).

    A cylinder has its diameter as both edges of its footprint. A moving obstacle starts at that
    centre and keeps its direction.
    """

    kind: Literal["box", "cylinder"]
    name: str
    x: float
    y: float
    yaw: float
    size: tuple[float, float, float]
    rgba: Rgba
    motion: Motion | None = None

    @classmethod
    def box(
        cls,
        name: str,
        x: float,
        y: float,
        *,
        yaw: float,
        size: tuple[float, float, float],
        colour: str,
    ) -> Obstacle:
        """Return a box; `yaw` in radians."""
        return cls("box", name, x, y, yaw, size, rgba(colour))

    @classmethod
    def cylinder(
        cls, name: str, x: float, y: float, *, radius: float, height: float, colour: str
    ) -> Obstacle:
        """Return an upright cylinder."""
        return cls("cylinder", name, x, y, 0.0, (2 * radius, 2 * radius, height), rgba(colour))

    def turned(self, yaw: float) -> Obstacle:
        """Return it in a direction, rad; a cylinder has none."""
        return self if self.kind == "cylinder" else replace(self, yaw=yaw)

    @property
    def radius(self) -> float:
        """Half the first edge: the radius of a cylinder, m."""
        return self.size[0] / 2

    @property
    def height(self) -> float:
        """Its height, m."""
        return self.size[2]

    def distance(self, x: float, y: float) -> float:
        """Return the distance of a point on the floor from the footprint, m; negative inside."""
        dx, dy = x - self.x, y - self.y
        if self.kind == "cylinder":
            return math.hypot(dx, dy) - self.radius
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        along = abs(dx * cos + dy * sin) - self.size[0] / 2
        across = abs(dy * cos - dx * sin) - self.size[1] / 2
        outside = math.hypot(max(along, 0.0), max(across, 0.0))
        return outside + min(max(along, across), 0.0)
