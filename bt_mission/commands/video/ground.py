"""The ground image: the world, its zones, waypoints, and the robot's path."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow
from PIL import ImageDraw

from bt_mission.commands.video.mp4 import Picture
from bt_mission.views.drawing.png import font

Point = tuple[float, float]
Zone = tuple[str, float, float, float]
"""A named round place: name, x, y and radius, m."""

WAY = (20, 110, 235)
WAYPOINT = (255, 255, 255)
SCAN = (235, 30, 50)
MOST_WAYPOINTS = 200
"""More are not marked: they would cover the world."""

_SHIFT = 4
"""Bits of a pixel's fraction in coordinates, for smooth lines."""
_STEP_PX = 1.5


class Ground:
    """An image on which the robot's path is drawn; it never grows.

    Args:
        still: The world from above; it is copied.
        pixel: Returns the pixels of points of the map: numbers, or arrays of them.
    """

    def __init__(self, still: Picture, pixel: Callable[[Any, Any], tuple[Any, Any]]) -> None:
        self.picture: Picture = still.copy()
        self._pixel = pixel
        self._last: Point | None = None
        self._marked: dict[tuple[float, float], int] = {}

    def name_zones(self, zones: Iterable[Zone]) -> None:
        """Write the name of each zone at its upper edge."""
        for name, x, y, radius in zones:
            u, v = self._pixel(x, y + radius)
            self._write(name, (u, v + 12), 15)

    def mark(self, x: float, y: float) -> None:
        """Mark a waypoint, with its number, once."""
        place = (round(x, 2), round(y, 2))
        if place in self._marked or len(self._marked) >= MOST_WAYPOINTS:
            return
        self._marked[place] = number = len(self._marked) + 1
        if not all(map(math.isfinite, place)):
            return
        u, v = self._pixel(x, y)
        for colour, thick in (((0, 0, 0), 5), (WAYPOINT, 2)):
            cv2.circle(
                self.picture, _fixed((u, v)), 9 << _SHIFT, colour, thick, cv2.LINE_AA, _SHIFT
            )
        self._write(str(number), (u + 19, v - 13), 15)

    def go(self, x: float, y: float) -> None:
        """Draw the robot's way on to here."""
        here = self._pixel(x, y)
        if self._last is not None:
            if math.dist(self._last, here) < _STEP_PX:
                return
            cv2.line(self.picture, _fixed(self._last), _fixed(here), WAY, 3, cv2.LINE_AA, _SHIFT)
        self._last = here

    def with_scan(self, points: npt.NDArray[np.float64]) -> Picture:
        """A copy in which the lidar's points (n x 2, m) are marked."""
        picture = self.picture.copy()
        height, width, _ = picture.shape
        if len(points):
            us, vs = self._pixel(points[:, 0], points[:, 1])
            columns, rows = us.astype(int), vs.astype(int)
            inside = (columns > 0) & (columns < width) & (rows > 0) & (rows < height)
            columns, rows = columns[inside], rows[inside]
            for down in (0, 1):
                for across in (0, 1):
                    picture[rows - down, columns - across] = SCAN
        return picture

    def _write(self, text: str, at: Point, size: int) -> None:
        image = Pillow.fromarray(self.picture)
        ImageDraw.Draw(image).text(
            at,
            text,
            fill="white",
            font=font(size, bold=True),
            anchor="mm",
            stroke_width=2,
            stroke_fill="black",
        )
        self.picture[:] = np.asarray(image)


def _fixed(point: Point) -> tuple[int, int]:
    u, v = (round(part * (1 << _SHIFT)) for part in point)
    return u, v
