"""The places that a mission names: its own, and the zones of the world that it runs in."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from bt_mission.base.diagnostics import InputError
from bt_mission.base.files import look_for
from bt_mission.base.yaml.document import read
from bt_mission.language.expressions.places import AnyPlace, Places, Pose
from bt_mission.language.permissions import ANYTHING, Permissions


def places_of(
    own: Mapping[str, Pose],
    world: str | None,
    file: str,
    zones: Mapping[str, Pose] | None = None,
    permissions: Permissions = ANYTHING,
) -> Places:
    """Return the places of a mission.

    Args:
        own: Those in its `places`.
        world: Its world, by name or path.
        file: The mission's.
        zones: Those of another world that it runs in, or `AnyPlace`; None reads its own.
        permissions: What files may be read.
    """
    if isinstance(zones, AnyPlace):
        return Places(own, AnyPlace)
    if zones is not None:
        return Places(own, partial(dict, zones))
    return Places(own, partial(zones_of_file, world or "", file, permissions), bool(world))


def zones_of_file(world: str, file: str, permissions: Permissions = ANYTHING) -> Mapping[str, Pose]:
    """Return the zones of a world, by its name or path, for a mission in a file.

    Errors of the world are reported where it is loaded.
    """
    path = look_for("worlds", world, file) if world else None
    if path is None or not permissions.allows(path, "worlds"):
        return {}
    try:
        data = read(path).data
    except InputError:
        return {}
    return zones_in(data)


def zones_in(world: Any) -> Mapping[str, Pose]:
    """Return the zones in what was read of a world file; a robot faces along x there."""
    entries = world.get("zones") if isinstance(world, dict) else None
    places: dict[str, Pose] = {}
    for entry in entries if isinstance(entries, list) else ():
        match entry:
            case {"name": str(name), "x": int() | float() as x, "y": int() | float() as y}:
                places[name] = (float(x), float(y), 0.0)
    return places
