"""The plan of a world as a map shows it, of a world file or of the world that a mission names."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import look_for
from bt_mission.base.text import escape_control
from bt_mission.base.yaml.document import read_text
from bt_mission.commands.edit.checks import permissions
from bt_mission.commands.edit.source import dotted
from bt_mission.commands.edit.world_patches import SPAWN, values_of
from bt_mission.sessions.stage_files import DEFAULT_WORLD
from sim.world.loader import load_world
from sim.world.world import SlipperyPatch, World, Zone


def plan_of(text: str, path: Path, kind: str, folder: Path) -> dict[str, Any] | None:
    """Return the plan of the world of a text; None if it cannot be read.

    Args:
        text: Of a world file, or of a file that names a world.
        path: Of the file, which need not exist.
        kind: Of the file.
        folder: A world is read from there and below, or is a shipped one.
    """
    try:
        document = read_text(text, str(path))
        if kind == "world":
            plan = _plan(load_world(document))
            things = (*plan["shapes"], *plan["zones"])
            values = {dotted(thing["path"]): values_of(text, thing["path"]) for thing in things}
            return {**plan, "values": {**values, SPAWN: values_of(text, (SPAWN,))}}
        head = document.data if isinstance(document.data, Mapping) else {}
        file = look_for("worlds", str(head.get("world") or DEFAULT_WORLD), path)
        if file is None or not permissions(folder).allows(file, "worlds"):
            return None
        return _plan(load_world(file))
    except BtMissionError:
        return None


def _plan(world: World) -> dict[str, Any]:
    spawn = world.spawn
    marks: tuple[tuple[str, Sequence[Zone | SlipperyPatch]], ...] = (
        ("zones", world.zones),
        ("slippery", world.slippery),
    )
    return {
        "name": escape_control(world.name),
        "size": list(world.size),
        "spawn": [spawn.x, spawn.y, spawn.yaw],
        "shapes": [
            {
                "path": list(placed.path),
                "kind": placed.obstacle.kind,
                "name": escape_control(placed.obstacle.name),
                "x": placed.obstacle.x,
                "y": placed.obstacle.y,
                "yaw": math.degrees(placed.obstacle.yaw),
                "size": list(placed.obstacle.size[:2]),
            }
            for placed in world.placed
        ],
        "zones": [
            {
                "path": [section, index],
                "name": escape_control(zone.name),
                "x": zone.x,
                "y": zone.y,
                "radius": zone.radius,
            }
            for section, zones in marks
            for index, zone in enumerate(zones)
        ],
    }
