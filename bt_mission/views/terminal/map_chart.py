"""A map in characters: walls, robot, trail, scan, waypoints.

A character cell is about twice as high as wide, so it holds two square pixels, one above the other.
Walls are drawn in pixels; moving things have separate signs, so that the map is readable without
colour.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from bt_mission.base.geometry import Pose2D, composed
from bt_mission.executive.events.messages import Map
from bt_mission.executive.events.robot_state import RobotState
from bt_mission.views.terminal.marks import PLACES, Marks, Span, clean

OCCUPIED = 50
"""Cells of a map from this value on, of 100, are walls."""

MARGIN_M = 0.3
LEAST_M = 3.0
"""At least so much of the world is shown."""

Grid = npt.NDArray[np.int8]
FREE, UNKNOWN, WALL = 0, 1, 2


@dataclass(frozen=True)
class ChartWindow:
    """The part of the world in a chart.

    Args:
        left: The left edge, m; top: the upper edge, m.
        pixel: The side of a pixel, m.
        width: Pixels, one for each column; height: pixels, two for each row.
    """

    left: float
    top: float
    pixel: float
    width: int
    height: int

    def at(self, x: float, y: float) -> tuple[int, int] | None:
        """Return the pixel of a place, as row and column; None outside."""
        if not math.isfinite(x + y):
            return None
        column = math.floor((x - self.left) / self.pixel)
        row = math.floor((self.top - y) / self.pixel)
        return (row, column) if 0 <= row < self.height and 0 <= column < self.width else None


class MapChart:
    """Draws a robot and its surroundings; keeps the walls between two drawings."""

    def __init__(self, marks: Marks) -> None:
        self._marks = marks
        self._drawn: tuple[Map, ChartWindow] | None = None
        self._walls: Grid = np.zeros((0, 0), np.int8)

    def draw(
        self, robot: RobotState, targets: Sequence[tuple[float, float]], columns: int, rows: int
    ) -> list[list[Span]]:
        """Return rows of spans, as many as requested; empty ones without a robot.

        Args:
            targets: Poses to which the robot is sent, in order, m.
        """
        scan = robot.scan_points()
        frame = fitting(robot, scan, targets, columns, rows)
        if frame is None:
            return []
        pixels = self._pixels(robot.map, frame)
        signs = self._signs(robot, frame, scan, targets, pixels)
        return [self._row(row, pixels, signs) for row in range(rows)]

    def _pixels(self, grid: Map | None, frame: ChartWindow) -> Grid:
        """The map in the chart's pixels."""
        if grid is None:
            return np.zeros((frame.height, frame.width), np.int8)
        if self._drawn is None or self._drawn[0] is not grid or self._drawn[1] != frame:
            self._drawn = (grid, frame)
            self._walls = _rasterised(grid, frame)
        return self._walls

    def _signs(
        self,
        robot: RobotState,
        frame: ChartWindow,
        scan: Sequence[tuple[float, float]],
        targets: Sequence[tuple[float, float]],
        pixels: Grid,
    ) -> dict[tuple[int, int], Span]:
        """Return the signs over the map, by row and column of the cell; later ones are on top."""
        signs: dict[tuple[int, int], Span] = {}

        def put(x: float, y: float, sign: Span) -> None:
            if at := frame.at(x, y):
                signs[at[0] // 2, at[1]] = sign

        for x, y, text, style in self._labels(robot):
            for number, letter in enumerate(text):
                put(x + number * frame.pixel, y, (letter, style))
        for x, y in robot.trail:
            put(x, y, (self._marks.trail, "trail"))
        for x, y in scan:
            if at := frame.at(x, y):
                wall = _wall_near(pixels, at)
                cell = (wall[0] // 2, wall[1]) if wall else (at[0] // 2, at[1])
                signs[cell] = (self._wall(pixels, *cell) if wall else self._marks.scan, "scan")
        for number, (x, y) in enumerate(targets):
            put(x, y, (PLACES[min(number, len(PLACES) - 1)], "waypoint"))
        if pose := robot.pose:
            put(pose.x, pose.y, (self._arrow(pose), "robot"))
        return signs

    def _labels(self, robot: RobotState) -> Iterator[tuple[float, float, str, str]]:
        """Yield what is written on the map: where it begins, m, the text, and its style."""
        for zone in robot.zones:
            yield zone.x, zone.y, clean(zone.name, self._marks), "zone"
        for name, other in robot.others.items():
            yield other.x, other.y, self._arrow(other) + clean(name, self._marks), "other"

    def _row(self, row: int, pixels: Grid, signs: dict[tuple[int, int], Span]) -> list[Span]:
        spans: list[Span] = []
        for column in range(pixels.shape[1]):
            text, style = signs.get((row, column)) or (self._wall(pixels, row, column), "wall")
            if spans and spans[-1][1] == style:
                spans[-1] = (spans[-1][0] + text, style)
            else:
                spans.append((text, style))
        return spans

    def _wall(self, pixels: Grid, row: int, column: int) -> str:
        upper, lower = pixels[2 * row, column], pixels[2 * row + 1, column]
        if upper == WALL and lower == WALL:
            return self._marks.wall[2]
        if upper == WALL:
            return self._marks.wall[0]
        if lower == WALL:
            return self._marks.wall[1]
        return self._marks.unknown if upper == lower == UNKNOWN else " "

    def _arrow(self, pose: Pose2D) -> str:
        arrows = self._marks.arrows
        return arrows[round(pose.yaw / (2 * math.pi) * len(arrows)) % len(arrows)]


def _wall_near(pixels: Grid, at: tuple[int, int]) -> tuple[int, int] | None:
    """The pixel of a wall that a ray has hit: a hit that is a pixel off, by noise, counts."""
    row, column = at
    for down, right in ((0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)):
        r, c = row + down, column + right
        if 0 <= r < pixels.shape[0] and 0 <= c < pixels.shape[1] and pixels[r, c] == WALL:
            return r, c
    return None


def fitting(
    robot: RobotState,
    scan: Sequence[tuple[float, float]],
    targets: Sequence[tuple[float, float]],
    columns: int,
    rows: int,
) -> ChartWindow | None:
    """Return the frame of all known things; None without any."""
    places = [*robot.trail, *targets, *((other.x, other.y) for other in robot.others.values())]
    if robot.map is not None:
        places += _corners(robot.map)
    else:
        places += scan
    if robot.pose is not None:
        places.append((robot.pose.x, robot.pose.y))
    places = [place for place in places if math.isfinite(place[0] + place[1])]
    if not places or columns < 1 or rows < 1:
        return None
    xs, ys = [x for x, _ in places], [y for _, y in places]
    width = max(max(xs) - min(xs) + 2 * MARGIN_M, LEAST_M)
    height = max(max(ys) - min(ys) + 2 * MARGIN_M, LEAST_M)
    finest = robot.map.resolution if robot.map is not None else 0.01
    pixel = _rounded_up(max(width / columns, height / (2 * rows), finest))
    middle_x, middle_y = (min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2
    # On a fixed grid, so that a frame that has to grow does not make walls flicker.
    left = math.floor((middle_x - columns * pixel / 2) / pixel) * pixel
    top = math.ceil((middle_y + rows * pixel) / pixel) * pixel
    return ChartWindow(left, top, pixel, columns, 2 * rows)


def _rounded_up(pixel: float) -> float:
    """The side of a pixel in steps of a tenth, m."""
    step: float = 10 ** math.floor(math.log10(pixel)) / 10
    return math.ceil(pixel / step) * step


def _corners(grid: Map) -> list[tuple[float, float]]:
    """Two corners of the part of a map that is known, m."""
    rows, columns = np.nonzero(_cells(grid) >= 0)
    if not len(rows):
        return []
    low = _place(grid, float(columns.min()), float(rows.min()))
    high = _place(grid, float(columns.max() + 1), float(rows.max() + 1))
    return [low, high]


def _place(grid: Map, column: float, row: float) -> tuple[float, float]:
    inner = Pose2D(column * grid.resolution, row * grid.resolution, 0.0)
    at = composed(Pose2D(grid.x, grid.y, grid.yaw), inner)
    return at.x, at.y


def _cells(grid: Map) -> Grid:
    cells = np.frombuffer(grid.cells, np.int8)
    if len(cells) != grid.width * grid.height:
        return np.full((1, 1), -1, np.int8)
    return cells.reshape(grid.height, grid.width)


def _rasterised(grid: Map, frame: ChartWindow) -> Grid:
    """Return a map in the pixels of a frame: a pixel is a wall if any of its cells is one.

    If none of its cells is known it is unknown, as long as there is something known around.
    """
    cells = _cells(grid)
    rows, columns = np.indices(cells.shape)
    across, along = (columns + 0.5) * grid.resolution, (rows + 0.5) * grid.resolution
    cos, sin = math.cos(grid.yaw), math.sin(grid.yaw)
    x = grid.x + cos * across - sin * along
    y = grid.y + sin * across + cos * along
    at_column = np.floor((x - frame.left) / frame.pixel).astype(int)
    at_row = np.floor((frame.top - y) / frame.pixel).astype(int)
    inside = (at_row >= 0) & (at_row < frame.height) & (at_column >= 0) & (at_column < frame.width)
    pixels = np.full((frame.height, frame.width), FREE, np.int8)
    inside &= _around_known(cells)
    for kind, of_kind in ((UNKNOWN, cells < 0), (FREE, cells >= 0), (WALL, cells >= OCCUPIED)):
        chosen = inside & of_kind
        pixels[at_row[chosen], at_column[chosen]] = kind
    return pixels


def _around_known(cells: Grid) -> npt.NDArray[np.bool_]:
    """The cells of the rectangle that holds everything known."""
    known = np.zeros(cells.shape, np.bool_)
    rows, columns = np.nonzero(cells >= 0)
    if len(rows):
        known[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1] = True
    return known
