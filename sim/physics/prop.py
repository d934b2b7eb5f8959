"""One prop: its shape, and the ways it goes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Protocol

from bt_mission.core.errors import BtMissionError
from sim.world.motion import Course, Drifting, PassingCourse, Point
from sim.world.shapes import Obstacle
from sim.world.world import FARTHEST, FASTEST, SHORTEST


class PropError(BtMissionError):
    """A prop that cannot be placed, or cannot move, as it was told."""


class PropWorld(Protocol):
    """The world that a prop is in, as far as the prop needs it."""

    @property
    def time_ns(self) -> int:
        """The present instant, ns."""

    def holds(self, prop: Prop, index: int) -> bool:
        """Return whether that prop is in the world."""

    def remove(self, index: int) -> None:
        """Put a spare body away."""

    def check_floor(self, name: str, x: float, y: float) -> None:
        """Raise PropError for a place that is not on the floor."""


class Prop:
    """One prop in the world, from when it was placed until it is removed.

    Each way begins where it is and replaces the one before. Metres, m/s; at most 2 m/s. Raises
    PropError for a way that it cannot go, and once it has been removed.
    """

    def __init__(self, props: PropWorld, index: int, obstacle: Obstacle) -> None:
        self._props = props
        self._index = index
        self.obstacle = obstacle
        """Its shape, name and direction, and where it was placed."""
        self.course: Course = Drifting((obstacle.x, obstacle.y))
        """Where it is, as a function of the time since `since_ns`."""
        self.since_ns = props.time_ns

    def __repr__(self) -> str:
        return f"<{self.obstacle.kind} '{self.name}'>"

    @property
    def name(self) -> str:
        """What its collisions are reported as."""
        return self.obstacle.name

    @property
    def is_placed(self) -> bool:
        """Whether it is in the world."""
        return self._props.holds(self, self._index)

    @property
    def position(self) -> Point:
        """Where its centre is now, or was when it was removed."""
        return self._now()[:2]

    @property
    def velocity(self) -> Point:
        """How fast it moves now, along x and y."""
        return self._now()[2:]

    def move_to(self, x: float, y: float, speed: float) -> None:
        """Go straight there, and stand."""
        self.follow([(x, y)], speed)

    def follow(self, points: Sequence[Point], speed: float) -> None:
        """Go straight from point to point, and stand at the last."""
        points = [self.position, *points]
        for x, y in points[1:]:
            self._props.check_floor(self.name, x, y)
        if not 0 < speed <= FASTEST:
            raise PropError(
                f"prop '{self.name}': expected a speed above 0 m/s and up to {FASTEST:g} m/s,"
                f" got {speed:g} m/s"
            )
        # Standing at a point for no time is to pass it.
        way = [points[0], *(b for a, b in pairwise(points) if math.dist(a, b) > 0)]
        self._go(PassingCourse(tuple(way), speed) if len(way) > 1 else Drifting(way[0]))

    def move_at(self, vx: float, vy: float) -> None:
        """Go on at this velocity, along x and y of the map, until told otherwise."""
        if not math.hypot(vx, vy) <= FASTEST:
            raise PropError(
                f"prop '{self.name}': expected a velocity of at most {FASTEST:g} m/s,"
                f" got ({vx:g}, {vy:g}) m/s"
            )
        self._go(Drifting(self.position, (vx, vy)))

    def stop(self) -> None:
        """Stand where it is."""
        self.move_at(0.0, 0.0)

    def remove(self) -> None:
        """Vanish. It may be gone already, by a reset too."""
        if self.is_placed:
            self._props.remove(self._index)

    def _go(self, course: Course) -> None:
        if not self.is_placed:
            raise PropError(f"prop '{self.name}' is not in the world any more; place a new one")
        self.course, self.since_ns = course, self._props.time_ns

    def _now(self) -> tuple[float, float, float, float]:
        return self.course.at((self._props.time_ns - self.since_ns) / 1e9)


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
