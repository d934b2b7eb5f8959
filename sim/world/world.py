"""Worlds: floor, walls, boxes, cylinders, zones and spawn, as a person writes them in YAML.

Metres and degrees (as in missions), x to the right and y up on the map, heights from the floor.
`World.obstacles` is the same as plain shapes.
"""

import math
from abc import abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from bt_mission.base.nature_field import WrittenNature
from sim.world.motion import Circling, Motion, Patrolling
from sim.world.shapes import Colour, Obstacle

FASTEST = 2.0
"""m/s that an obstacle may move at: 1 cm in a step of the physics."""

FARTHEST = 100.0
"""Metres. A map of 100 m x 100 m has four million cells of 0.05 m."""

SHORTEST = 0.001
"""Metres. Anything thinner or shorter is taken for a slip of the pen."""

Coordinate = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST, allow_inf_nan=False)]
Extent = Annotated[float, Field(ge=SHORTEST, le=FARTHEST, allow_inf_nan=False)]
Degrees = Annotated[float, Field(ge=-360, le=360, allow_inf_nan=False)]
Name = Annotated[str, Field(min_length=1, max_length=60)]
Point = tuple[Coordinate, Coordinate]


class WorldPart(BaseModel):
    """What is written of a part of a world: fixed, and nothing that nobody knows."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


class Wall(WorldPart):
    """A straight wall: between two points, or a centre with a length and a direction."""

    name: Name | None = None
    start: Point | None = Field(default=None, alias="from")
    to: Point | None = None
    centre: Point | None = None
    length: Extent | None = None
    yaw: Degrees = 0.0
    thickness: Extent = 0.1
    height: Extent = 0.5
    colour: Colour = "white"

    @model_validator(mode="after")
    def _exclude_mixed_forms(self) -> Self:
        ends = self.start is not None and self.to is not None
        middle = self.centre is not None and self.length is not None
        mixed = {"start", "to"} & self.model_fields_set and {
            "centre",
            "length",
            "yaw",
        } & self.model_fields_set
        if mixed or not (ends or middle):
            raise ValueError(
                "a wall is written with 'from' and 'to', or with 'centre', 'length'"
                " and 'yaw' (degrees); not with a part or a mixture of these"
            )
        if ends and math.dist(self.start or (), self.to or ()) < SHORTEST:
            raise ValueError(f"a wall from {_words(self.start)} to {_words(self.to)} has no length")
        return self

    def obstacle(self, name: str) -> Obstacle:
        """Return the wall as a shape. Its length lies along its direction."""
        if self.start is not None and self.to is not None:
            (x0, y0), (x1, y1) = self.start, self.to
            x, y, yaw = (x0 + x1) / 2, (y0 + y1) / 2, math.atan2(y1 - y0, x1 - x0)
            length = math.dist(self.start, self.to)
        else:
            assert self.centre is not None
            assert self.length is not None
            (x, y), yaw, length = self.centre, math.radians(self.yaw), self.length
        return Obstacle.box(
            name, x, y, yaw=yaw, size=(length, self.thickness, self.height), colour=self.colour
        )


class Moving(WorldPart):
    """The motion of an obstacle: `around` a point with `period`, or `through` points at `speed`.

    `period` in s, negative for clockwise; `speed` in m/s. After the last point it returns straight.
    """

    around: Point | None = None
    period: Annotated[float, Field(ge=-1e5, le=1e5, allow_inf_nan=False)] | None = None
    through: Annotated[tuple[Point, ...], Field(min_length=1, max_length=200)] | None = None
    speed: Annotated[float, Field(gt=0, le=FASTEST, allow_inf_nan=False)] | None = None

    @model_validator(mode="after")
    def _exclude_mixed_motions(self) -> Self:
        given = {field for field in type(self).model_fields if getattr(self, field) is not None}
        if given not in ({"around", "period"}, {"through", "speed"}):
            raise ValueError(
                "a motion is written with 'around' and 'period' (s), or with 'through' and"
                " 'speed' (m/s); not with a part or a mixture of these"
            )
        if self.period is not None and abs(self.period) < 1:
            raise ValueError(f"expected a period of 1 s or longer, got {self.period:g} s")
        return self

    def of(self, start: Point) -> Motion:
        """Return the motion of what starts there."""
        if self.around is not None and self.period is not None:
            return Circling(start, self.around, self.period)
        assert self.through is not None
        assert self.speed is not None
        return Patrolling((start, *self.through), self.speed)

    def problem(self, start: Point) -> str | None:
        """Return why nothing can move so from there, or None."""
        points = (start, *(self.through or ()))
        stops = any(math.dist(a, b) < SHORTEST for a, b in pairwise((*points, start)))
        if self.through is not None and stops:
            return "a motion goes through points that differ, its own place among them"
        if self.around is not None and self.period is not None:
            speed = math.tau * math.dist(start, self.around) / abs(self.period)
            if speed > FASTEST:
                return f"a motion is at most {FASTEST:g} m/s fast, this one {speed:.3g} m/s"
        return None


class MovableShape(WorldPart):
    """A box or a cylinder on the floor, which may move."""

    name: Name | None = None
    x: Coordinate
    y: Coordinate
    motion: Moving | None = None

    def obstacle(self, name: str) -> Obstacle:
        """Return it as a shape."""
        shape = self._still(name)
        return (
            shape
            if self.motion is None
            else replace(shape, motion=self.motion.of((self.x, self.y)))
        )

    @abstractmethod
    def _still(self, name: str) -> Obstacle:
        """Return it without its motion."""

    @model_validator(mode="after")
    def _can_move(self) -> Self:
        problem = self.motion and self.motion.problem((self.x, self.y))
        if problem:
            raise ValueError(problem)
        return self


class Box(MovableShape):
    """A box on the floor: centre, edges along its x, y and z axes, direction."""

    size: tuple[Extent, Extent, Extent]
    yaw: Degrees = 0.0
    colour: Colour = "brown"

    def _still(self, name: str) -> Obstacle:
        yaw = math.radians(self.yaw)
        return Obstacle.box(name, self.x, self.y, yaw=yaw, size=self.size, colour=self.colour)


class Cylinder(MovableShape):
    """An upright cylinder on the floor."""

    radius: Extent
    height: Extent = 0.5
    colour: Colour = "grey"

    def _still(self, name: str) -> Obstacle:
        return Obstacle.cylinder(
            name, self.x, self.y, radius=self.radius, height=self.height, colour=self.colour
        )


class FloorMark(WorldPart):
    """A round place on the floor, in nobody's way."""

    name: Name
    x: Coordinate
    y: Coordinate


class Zone(FloorMark):
    """A round mark on the floor, visible to the camera."""

    radius: Extent = 0.4
    colour: Colour = "yellow"


class SlipperyPatch(FloorMark):
    """A round place with another coefficient of friction of wheels; elsewhere it is 1.

    The camera sees it, the lidar does not.
    """

    radius: Extent
    friction: Annotated[float, Field(ge=0, lt=1, allow_inf_nan=False)] = 0.05
    colour: Colour = "white"


class LooseBox(FloorMark):
    """A box that robots can push and grip: edges, kg, height of its lower side, friction.

    It is not on the map, and touching it is no collision.
    """

    size: tuple[Extent, Extent, Extent]
    mass: Annotated[float, Field(ge=1e-3, le=100, allow_inf_nan=False)]
    z: Annotated[float, Field(ge=0, le=10, allow_inf_nan=False)] = 0.0
    yaw: Degrees = 0.0
    friction: Annotated[float, Field(ge=0, le=2, allow_inf_nan=False)] = 1.0
    colour: Colour = "red"


class Spawn(WorldPart):
    """The start of `base_footprint`; `yaw` counter-clockwise from x."""

    x: Coordinate = 0.0
    y: Coordinate = 0.0
    yaw: Degrees = 0.0


class World(WorldPart):
    """A floor around the origin, its obstacles and marks, and the start, in m and degrees."""

    name: Name
    description: str = ""
    size: tuple[Extent, Extent]
    spawn: Spawn = Spawn()
    nature: WrittenNature | None = None
    walls: Annotated[tuple[Wall, ...], Field(max_length=2000)] = ()
    boxes: Annotated[tuple[Box, ...], Field(max_length=2000)] = ()
    cylinders: Annotated[tuple[Cylinder, ...], Field(max_length=2000)] = ()
    zones: Annotated[tuple[Zone, ...], Field(max_length=200)] = ()
    slippery: Annotated[tuple[SlipperyPatch, ...], Field(max_length=200)] = ()
    objects: Annotated[tuple[LooseBox, ...], Field(max_length=50)] = ()

    def has_floor_at(self, x: float, y: float) -> bool:
        """Return whether a place (m) is on the floor."""
        return abs(x) <= self.size[0] / 2 and abs(y) <= self.size[1] / 2

    @property
    def floor(self) -> str:
        """The floor, as messages name it."""
        length, width = self.size
        return f"the floor of {length:g} m x {width:g} m around (0, 0)"

    @cached_property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """Everything that a robot can run into, in the order of the file, each with its name."""
        return tuple(placed.obstacle for placed in self.placed)

    @cached_property
    def moving(self) -> tuple[Obstacle, ...]:
        """The obstacles that move."""
        return tuple(obstacle for obstacle in self.obstacles if obstacle.motion is not None)

    @cached_property
    def placed(self) -> "tuple[Placed, ...]":
        """The obstacles with their places in the file."""
        sections: tuple[tuple[str, str, tuple[Wall | Box | Cylinder, ...]], ...] = (
            ("walls", "wall", self.walls),
            ("boxes", "box", self.boxes),
            ("cylinders", "cylinder", self.cylinders),
        )
        return tuple(
            Placed((section, index), thing.obstacle(thing.name or f"{kind} {index + 1}"))
            for section, kind, things in sections
            for index, thing in enumerate(things)
        )


@dataclass(frozen=True)
class Placed:
    """An obstacle, and the path of what was written for it: `("walls", 3)`."""

    path: tuple[str, int]
    obstacle: Obstacle


def _words(point: Point | None) -> str:
    return "nowhere" if point is None else f"[{point[0]:g}, {point[1]:g}]"
