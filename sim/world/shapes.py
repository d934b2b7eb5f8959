"""The shapes that worlds are made of: upright boxes and cylinders on the floor."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

from sim.world.colours import Rgba, rgba
from sim.world.motion import Motion


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
