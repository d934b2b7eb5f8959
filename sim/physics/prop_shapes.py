"""The number, shapes and sizes of props."""

from __future__ import annotations

import math

from bt_mission.base.errors import BtMissionError
from sim.world.shapes import Obstacle
from sim.world.world import FARTHEST, SHORTEST

MOST = 64
"""Props in one simulation."""


class PropError(BtMissionError):
    """A prop that cannot be placed, or cannot move as requested."""

    code = "BT-807"


def check_count(count: int) -> None:
    """Raise PropError for a number of props that cannot be."""
    if not 0 <= count <= MOST:
        raise PropError(f"expected 0 to {MOST} props in a simulation, got {count}")


def shape(
    name: str,
    place: tuple[float, float, float],
    size: tuple[float, float, float] | None,
    radius: float | None,
    height: float,
    colour: str,
) -> Obstacle:
    """Return a box, or a cylinder, at x, y (m) and yaw (deg). Raises PropError."""
    x, y, yaw_deg = place
    if (size is None) == (radius is None):
        raise PropError(
            f"prop '{name}': expected size=(length, width, height) for a box, or radius= (and"
            f" height=) for a cylinder; got {'neither' if size is None else 'both'}"
        )
    edges = (radius or 0.0, height) if size is None else tuple(size)
    if size is not None and len(edges) != 3:
        raise PropError(f"prop '{name}': expected size=(length, width, height), got {size}")
    if not all(SHORTEST <= edge <= FARTHEST for edge in edges):
        raise PropError(
            f"prop '{name}': expected {'radius and height' if size is None else 'edges'} from"
            f" {SHORTEST:g} m to {FARTHEST:g} m, got ({', '.join(f'{edge:g}' for edge in edges)})"
        )
    if not abs(yaw_deg) <= 360:
        raise PropError(f"prop '{name}': expected a yaw from -360 to 360 deg, got {yaw_deg:g}")
    try:
        if size is None:
            return Obstacle.cylinder(name, x, y, radius=edges[0], height=height, colour=colour)
        return Obstacle.box(name, x, y, yaw=math.radians(yaw_deg), size=size, colour=colour)
    except ValueError as error:
        raise PropError(f"prop '{name}': {error}") from error
