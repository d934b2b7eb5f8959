"""Worlds with walls around, and boxes and cylinders in them, some of which move."""

from __future__ import annotations

from typing import Any

from bt_mission.scenarios.draws import Draws, maybe, number, one_of

CELL = 0.9
"""m. Each obstacle has a cell of this size, so that obstacles do not touch."""

FREE = 0.75
"""m. Nothing is nearer to the spawn than this, seen from an obstacle's middle."""

MOST = 6
"""Obstacles."""

WALL = 0.1


def drawn_world(draws: Draws) -> dict[str, Any]:
    """A world, as data of a world file. The robot starts in the middle, with room to turn."""
    cells_x, cells_y = draws.whole(3, 6), draws.whole(3, 6)
    width, depth = cells_x * CELL, cells_y * CELL
    free = [
        (x, y) for x in _middles(cells_x) for y in _middles(cells_y) if max(abs(x), abs(y)) > FREE
    ]
    boxes: list[dict[str, Any]] = []
    cylinders: list[dict[str, Any]] = []
    for place in range(draws.whole(0, min(MOST, len(free)))):
        x, y = free.pop(draws.whole(0, len(free) - 1))
        name = f"obstacle {place + 1}"
        if one_of(draws, ("box", "cylinder")) == "box":
            boxes.append({"name": name, "x": x, "y": y} | _box(draws))
        else:
            cylinders.append({"name": name, "x": x, "y": y} | _cylinder(draws, x, y))
    return {
        "name": "drawn",
        "size": [round(width + 2 * WALL, 3), round(depth + 2 * WALL, 3)],
        "spawn": {"x": 0, "y": 0, "yaw": number(draws, 0, 345, 15)},
        "walls": _walls(width, depth),
        "boxes": boxes,
        "cylinders": cylinders,
    }


def _middles(cells: int) -> list[float]:
    return [round((i - (cells - 1) / 2) * CELL, 3) for i in range(cells)]


def _box(draws: Draws) -> dict[str, Any]:
    sides = [number(draws, 0.1, 0.4, 0.1), number(draws, 0.1, 0.4, 0.1), 0.5]
    return {"size": sides, "yaw": number(draws, 0, 75, 15)}


def _cylinder(draws: Draws, x: float, y: float) -> dict[str, Any]:
    cylinder: dict[str, Any] = {"radius": number(draws, 0.05, 0.2, 0.05), "height": 0.5}
    if maybe(draws, 4):
        cylinder["motion"] = {"through": [[x, _r(y + 0.2)]], "speed": 0.1}
    return cylinder


def _walls(width: float, depth: float) -> list[dict[str, Any]]:
    across, along = (width + WALL) / 2, (depth + WALL) / 2
    length = {"thickness": WALL, "height": 0.5}
    return [
        {"name": "north wall", "centre": [0, _r(along)], "length": _r(width + 2 * WALL), "yaw": 0}
        | length,
        {"name": "south wall", "centre": [0, _r(-along)], "length": _r(width + 2 * WALL), "yaw": 0}
        | length,
        {"name": "east wall", "centre": [_r(across), 0], "length": _r(depth), "yaw": 90} | length,
        {"name": "west wall", "centre": [_r(-across), 0], "length": _r(depth), "yaw": 90} | length,
    ]


def _r(value: float) -> float:
    return round(value, 3)
