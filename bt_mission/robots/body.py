"""The shapes of a robot's body, and the hull that follows from body and wheels."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Literal, Self, TypeAlias

from pydantic import Field, field_validator, model_validator

from bt_mission.robots.parts import Extent3, Length, Place, Point2, Point3, RobotPart, Size3

_FLAT = 1e-9


class BoxBody(RobotPart):
    """A box: edges along x, y, z, and centre, m."""

    shape: Literal["box"]
    size: Extent3
    centre: Point3

    @property
    def corners(self) -> tuple[Point2, ...]:
        """The corners seen from above, m."""
        (length, width, _), (x, y, _) = self.size, self.centre
        return tuple((x + i * length / 2, y + j * width / 2) for i in (1, -1) for j in (1, -1))

    @property
    def reach(self) -> float:
        """The distance of the farthest point from the origin, seen from above, m."""
        (length, width, _), (x, y, _) = self.size, self.centre
        return math.hypot(abs(x) + length / 2, abs(y) + width / 2)

    @property
    def heights(self) -> tuple[float, float]:
        """Its lower and its upper side, m."""
        return self.centre[2] - self.size[2] / 2, self.centre[2] + self.size[2] / 2


class CylinderBody(RobotPart):
    """An upright cylinder: radius, height and centre, m. Its hull is a circle."""

    shape: Literal["cylinder"]
    radius: Length
    height: Length
    centre: Point3

    @property
    def size(self) -> Size3:
        """The edges of the box around it, m."""
        return 2 * self.radius, 2 * self.radius, self.height

    @property
    def corners(self) -> tuple[Point2, ...]:
        """Its outermost points along x and y, m."""
        x, y, _ = self.centre
        r = self.radius
        return (x + r, y), (x - r, y), (x, y + r), (x, y - r)

    @property
    def reach(self) -> float:
        """The distance of the farthest point from the origin, seen from above, m."""
        return math.hypot(self.centre[0], self.centre[1]) + self.radius

    @property
    def heights(self) -> tuple[float, float]:
        """Its lower and its upper side, m."""
        return self.centre[2] - self.height / 2, self.centre[2] + self.height / 2


class PolygonBody(RobotPart):
    """A convex outline seen from above, x and y in m, in order; and its lower and upper side, m."""

    shape: Literal["polygon"]
    outline: Annotated[tuple[Point2, ...], Field(min_length=3, max_length=32)]
    bottom: Place
    top: Place

    @field_validator("outline")
    @classmethod
    def _closes(cls, outline: tuple[Point2, ...]) -> tuple[Point2, ...]:
        """Refuse an outline that crosses itself, repeats a corner or has a notch."""
        count = len(outline)
        turned, signs = 0.0, set()
        for index in range(count):
            (ax, ay), (bx, by), (cx, cy) = (outline[(index + k) % count] for k in range(3))
            cross = turn((ax, ay), (bx, by), (cx, cy))
            along = (bx - ax) * (cx - bx) + (by - ay) * (cy - by)
            if abs(cross) < _FLAT:
                raise ValueError(
                    f"corner {(index + 1) % count + 1} of the outline, ({bx:g}, {by:g}), repeats"
                    " another corner or lies on a straight edge; leave it out"
                )
            signs.add(cross > 0)
            turned += math.atan2(cross, along)
        if len(signs) > 1 or abs(abs(turned) - math.tau) > 1e-6:
            raise ValueError(
                "the outline does not close to a convex hull: its corners must follow each other"
                " around the robot, without a crossing or a notch"
            )
        return outline

    @model_validator(mode="after")
    def _has_height(self) -> Self:
        if self.bottom >= self.top:
            raise ValueError(f"bottom {self.bottom:g} m must be below top {self.top:g} m")
        return self

    @property
    def size(self) -> Size3:
        """The edges of the box around it, m."""
        xs, ys = zip(*self.outline, strict=True)
        return max(xs) - min(xs), max(ys) - min(ys), self.top - self.bottom

    @property
    def centre(self) -> Point3:
        """The middle of the box around it, m."""
        xs, ys = zip(*self.outline, strict=True)
        return (max(xs) + min(xs)) / 2, (max(ys) + min(ys)) / 2, (self.top + self.bottom) / 2

    @property
    def corners(self) -> tuple[Point2, ...]:
        """The corners of the outline, m."""
        return self.outline

    @property
    def reach(self) -> float:
        """The distance of the farthest point from the origin, seen from above, m."""
        return max(math.hypot(*corner) for corner in self.outline)

    @property
    def heights(self) -> tuple[float, float]:
        """Its lower and its upper side, m."""
        return self.bottom, self.top


Body: TypeAlias = Annotated[BoxBody | CylinderBody | PolygonBody, Field(discriminator="shape")]


@dataclass(frozen=True, slots=True)
class Hull:
    """The rectangle around body and wheels seen from above, m from the origin of the base."""

    front: float
    rear: float
    half_width: float


def convex(points: Iterable[Point2]) -> tuple[Point2, ...]:
    """Return the convex hull of points, counter-clockwise.

    A. M. Andrew, "Another efficient algorithm for convex hulls in two dimensions", Information
    Processing Letters 9 (1979), 216-219.
    """
    ordered = sorted(set(points))
    hull: list[Point2] = []
    for way in (ordered, ordered[::-1]):
        chain: list[Point2] = []
        for x, y in way:
            while len(chain) > 1 and turn(chain[-2], chain[-1], (x, y)) <= _FLAT:
                chain.pop()
            chain.append((x, y))
        hull += chain[:-1]
    return tuple(hull)


def turn(a: Point2, b: Point2, c: Point2) -> float:
    """Return above 0 if the way from a by b to c turns to the left."""
    return (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
