"""A picture of a case: the world with the recorded scans, and both paths."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np

from bt_mission.commands.reproduce.comparison import best
from bt_mission.commands.reproduce.evidence import Evidence, Floats
from bt_mission.commands.reproduce.sight import Visitor
from bt_mission.commands.reproduce.surroundings import StaticSurroundings
from bt_mission.commands.reproduce.tracing import Block, Disc, Segment

LONGEST_PX = 1000
MARGIN_PX, HEAD_PX = 24, 92
WHITE, BLACK, GREY = (255, 255, 255), (30, 30, 30), (170, 170, 170)
POINTS, WORLD = (205, 190, 150), (60, 60, 60)
RECORDED, SIMULATED, THING, ZONE = (200, 90, 20), (40, 40, 220), (20, 140, 230), (90, 200, 200)
"""Blue, green and red."""
TEXT = cv2.FONT_HERSHEY_SIMPLEX


def picture(
    title: str,
    evidence: Evidence,
    around: StaticSurroundings,
    things: Sequence[Visitor],
    simulated: Evidence | None,
) -> bytes:
    """Return a PNG: scans, world, things that came, zones, and the paths."""
    canvas = _Canvas(_extent(evidence, around))
    for zone in evidence.zones:
        canvas.circle(zone.x, zone.y, zone.radius, ZONE, 1)
    canvas.dots(around.points, POINTS)
    for thing in things:
        canvas.dots(thing.points, THING)
    for shape in around.shapes:
        match shape:
            case Segment():
                canvas.line(shape.a, shape.b, WORLD, max(2, canvas.px(shape.thickness)))
            case Block():
                canvas.box(shape, WORLD)
            case Disc():
                canvas.circle(shape.x, shape.y, shape.radius, WORLD, 2)
    for thing in things:
        if thing.radius is not None:
            canvas.circle(thing.x, thing.y, thing.radius, THING, 2)
        else:
            canvas.box(Block(thing.x, thing.y, *thing.size, thing.yaw), THING)
    canvas.path(best(evidence).x, best(evidence).y, RECORDED, 3)
    if simulated is not None:
        canvas.path(best(simulated).x, best(simulated).y, SIMULATED, 1)
    canvas.legend(title, bool(things), simulated is not None)
    done: Any = cv2.imencode(".png", canvas.image)
    return bytes(done[1].tobytes())


def _extent(evidence: Evidence, around: StaticSurroundings) -> tuple[float, float, float, float]:
    places = [np.column_stack((evidence.track.x, evidence.track.y))]
    places.append(around.cells.centres(around.cells.occupied))
    if len(around.points):
        low, high = np.percentile(around.points, (0.5, 99.5), axis=0)
        places.append(np.vstack((low, high)))
    every = np.vstack([each for each in places if len(each)])
    (x0, y0), (x1, y1) = every.min(axis=0), every.max(axis=0)
    return float(x0), float(y0), float(x1), float(y1)


class _Canvas:
    """A picture whose places are m, x to the right and y up."""

    def __init__(self, extent: tuple[float, float, float, float]) -> None:
        self._x, self._y, x1, y1 = extent
        width, height = max(x1 - self._x, 0.5), max(y1 - self._y, 0.5)
        self._scale = LONGEST_PX / max(width, height)
        self._rows = round(height * self._scale) + 2 * MARGIN_PX
        columns = max(round(width * self._scale) + 2 * MARGIN_PX, 560)
        self.image: Any = np.full((self._rows + HEAD_PX, columns, 3), 255, np.uint8)

    def px(self, metres: float) -> int:
        """Return a length in pixels."""
        return round(metres * self._scale)

    def at(self, x: float, y: float) -> tuple[int, int]:
        """Return the pixel of a place."""
        column = MARGIN_PX + (x - self._x) * self._scale
        row = HEAD_PX + self._rows - MARGIN_PX - (y - self._y) * self._scale
        limit = 20_000
        return round(max(-limit, min(column, limit))), round(max(-limit, min(row, limit)))

    def dots(self, points: Floats, colour: tuple[int, int, int]) -> None:
        """Draw points."""
        for x, y in points[:: max(1, len(points) // 30_000)]:
            cv2.circle(self.image, self.at(x, y), 1, colour, -1)

    def line(
        self,
        a: tuple[float, float],
        b: tuple[float, float],
        colour: tuple[int, int, int],
        width: int,
    ) -> None:
        """Draw a straight line."""
        cv2.line(self.image, self.at(*a), self.at(*b), colour, width, cv2.LINE_AA)

    def circle(
        self, x: float, y: float, radius: float, colour: tuple[int, int, int], width: int
    ) -> None:
        """Draw a circle."""
        size = max(2, self.px(radius))
        cv2.circle(self.image, self.at(x, y), size, colour, width, cv2.LINE_AA)

    def box(self, block: Block, colour: tuple[int, int, int]) -> None:
        """Draw the edges of a box."""
        cos, sin = math.cos(block.yaw), math.sin(block.yaw)
        corners = [
            self.at(
                block.x + cos * a * block.length / 2 - sin * b * block.width / 2,
                block.y + sin * a * block.length / 2 + cos * b * block.width / 2,
            )
            for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))
        ]
        cv2.polylines(self.image, [np.array(corners)], True, colour, 2, cv2.LINE_AA)

    def path(self, x: Floats, y: Floats, colour: tuple[int, int, int], width: int) -> None:
        """Draw a path, with a dot at its start."""
        if len(x) < 2:
            return
        stride = max(1, len(x) // 5000)
        line = np.array([self.at(a, b) for a, b in zip(x[::stride], y[::stride], strict=True)])
        cv2.polylines(self.image, [line], False, colour, width, cv2.LINE_AA)
        cv2.circle(self.image, self.at(x[0], y[0]), width + 4, colour, -1, cv2.LINE_AA)

    def legend(self, title: str, has_things: bool, has_simulated: bool) -> None:  # noqa: FBT001
        """Write the title, and what the colours mean."""
        cv2.putText(self.image, title[:70], (MARGIN_PX, 28), TEXT, 0.6, BLACK, 1, cv2.LINE_AA)
        entries = [("scans", POINTS), ("world", WORLD), ("recorded path", RECORDED)]
        entries += [("simulated path", SIMULATED)] if has_simulated else []
        entries += [("things that came", THING)] if has_things else []
        column = MARGIN_PX
        for words, colour in entries:
            cv2.rectangle(self.image, (column, 44), (column + 14, 58), colour, -1)
            cv2.putText(self.image, words, (column + 20, 57), TEXT, 0.42, BLACK, 1, cv2.LINE_AA)
            column += 30 + 8 * len(words)
        width = self.px(1.0)
        begin, row = MARGIN_PX, 78
        cv2.line(self.image, (begin, row), (begin + width, row), BLACK, 2)
        cv2.putText(
            self.image, "1 m", (begin + width + 8, row + 5), TEXT, 0.42, BLACK, 1, cv2.LINE_AA
        )
