"""The path of a recorded run over its map as PNG, with the verdicts of its requirements below."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

from bt_mission.base.text import escape_control
from bt_mission.base.verdicts import FAILING
from bt_mission.executive.events.messages import Map
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.recording.replay.player import TimelineSeeker
from bt_mission.recording.replay.timeline import Timeline
from bt_mission.views.drawing.png import font

LONGEST_PX = 640
MARGIN_M = 1.0
"""Shown around the path and the places of goals."""
LEAST_M = 6.0
ROW_PX, EDGE_PX, TEXT_PX = 20, 12, 13
MOST_ROWS = 12
LONGEST_TEXT = 88
OCCUPIED = 50
PAPER, INK, UNKNOWN, WALL = (255, 255, 255), (40, 40, 40), (226, 226, 226), (70, 70, 70)
PATH, START, ROBOT, PLACE, ZONE = (
    *((30, 100, 200), (40, 150, 70), (200, 50, 40), (220, 140, 20)),
    (140, 120, 190),
)
VIOLATED = (190, 30, 30)


class _Frame(NamedTuple):
    """The part of the world that is shown, m, and the pixels of a metre."""

    left: float
    top: float
    width: int
    height: int
    scale: float

    def at(self, x: float, y: float) -> tuple[float, float]:
        return (x - self.left) * self.scale, (self.top - y) * self.scale


def path_png(timeline: Timeline) -> bytes:
    """Return the picture of a run at its end."""
    state = TimelineSeeker(timeline).seek(timeline.end_ns)
    places = [(target.x, target.y) for goal in state.goals.values() for target in goal.targets]
    frame = _frame(state, places)
    rows = list(_rows(state))
    image = Image.new("RGB", (frame.width, frame.height + len(rows) * ROW_PX + EDGE_PX), PAPER)
    grid = state.robot.map
    if grid is not None and grid.width * grid.height == len(grid.cells) > 0:
        image.paste(Image.fromarray(_ground(grid, frame)), (0, 0))
    draw = ImageDraw.Draw(image)
    _draw_run(draw, frame, state, places)
    for number, (words, colour) in enumerate(rows):
        place = EDGE_PX, frame.height + EDGE_PX // 2 + number * ROW_PX
        draw.text(place, words, colour, font(TEXT_PX, bold=number == 0))
    stream = io.BytesIO()
    image.quantize(64).save(stream, "PNG", optimize=True)
    return stream.getvalue()


def _frame(state: MissionState, places: Sequence[tuple[float, float]]) -> _Frame:
    robot = state.robot
    near = [point for point in (*robot.trail, *places) if math.isfinite(point[0] + point[1])]
    (x0, y0), (x1, y1) = (
        (min(x for x, _ in near), min(y for _, y in near)) if near else (0.0, 0.0),
        (max(x for x, _ in near), max(y for _, y in near)) if near else (0.0, 0.0),
    )
    x0, x1 = _widened(x0 - MARGIN_M, x1 + MARGIN_M)
    y0, y1 = _widened(y0 - MARGIN_M, y1 + MARGIN_M)
    scale = LONGEST_PX / max(x1 - x0, y1 - y0)
    width, height = round((x1 - x0) * scale), round((y1 - y0) * scale)
    return _Frame(x0, y1, max(width, LONGEST_PX), height, scale)


def _widened(low: float, high: float) -> tuple[float, float]:
    missing = max(LEAST_M - (high - low), 0.0) / 2
    return low - missing, high + missing


def _ground(grid: Map, frame: _Frame) -> npt.NDArray[np.uint8]:
    """Return the map in the pixels of the picture: white is free."""
    x = frame.left + (np.arange(frame.width) + 0.5) / frame.scale - grid.x
    y = (frame.top - (np.arange(frame.height) + 0.5) / frame.scale - grid.y)[:, None]
    cos, sin = math.cos(grid.yaw), math.sin(grid.yaw)
    columns = np.floor((cos * x + sin * y) / grid.resolution).astype(np.int64)
    rows = np.floor((cos * y - sin * x) / grid.resolution).astype(np.int64)
    inside = (columns >= 0) & (columns < grid.width) & (rows >= 0) & (rows < grid.height)
    cells = np.frombuffer(grid.cells, np.int8).reshape(grid.height, grid.width)
    values = np.where(inside, cells[rows * inside, columns * inside], -1)
    pixels = np.full((*values.shape, 3), PAPER, np.uint8)
    pixels[values < 0] = UNKNOWN
    pixels[values >= OCCUPIED] = WALL
    return pixels


def _draw_run(
    draw: Any, frame: _Frame, state: MissionState, places: Sequence[tuple[float, float]]
) -> None:
    robot = state.robot
    for zone in robot.zones:
        (u, v), reach = frame.at(zone.x, zone.y), zone.radius * frame.scale
        draw.ellipse((u - reach, v - reach, u + reach, v + reach), outline=ZONE, width=2)
        draw.text((u - reach, v - reach), _short(zone.name), ZONE, font(TEXT_PX, bold=False))
    for number, (x, y) in enumerate(places[-30:], 1):
        u, v = frame.at(x, y)
        draw.ellipse((u - 5, v - 5, u + 5, v + 5), outline=PLACE, width=2)
        draw.text((u + 7, v - 14), str(number), PLACE, font(TEXT_PX, bold=True))
    if len(robot.trail) > 1:
        draw.line([frame.at(*point) for point in robot.trail], PATH, 3, joint="curve")
    if robot.trail:
        u, v = frame.at(*robot.trail[0])
        draw.ellipse((u - 6, v - 6, u + 6, v + 6), START)
    if (pose := robot.pose) is not None:
        corners = ((10, 0.0), (8, 2.5), (8, -2.5))
        (u, v), turned = frame.at(pose.x, pose.y), [(r, pose.yaw + a) for r, a in corners]
        draw.polygon([(u + r * math.cos(a), v - r * math.sin(a)) for r, a in turned], ROBOT)


def _rows(state: MissionState) -> Iterator[tuple[str, tuple[int, int, int]]]:
    """Yield the outcome, and a row for each requirement."""
    mission = state.tree.mission if state.tree else "a run"
    yield _short(f"{mission}: {state.headline}"), INK
    for each in state.requirements[:MOST_ROWS]:
        yield _short(f"{each.name}: {each.outcome}"), VIOLATED if each.verdict in FAILING else INK


def _short(text: str) -> str:
    shown = escape_control(text)
    return shown if len(shown) <= LONGEST_TEXT else f"{shown[: LONGEST_TEXT - 3]}..."
