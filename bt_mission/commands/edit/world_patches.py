"""Acts on the map of a world file, as patches of its text, and the fields of what is on the map."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import count
from typing import Any

from bt_mission.base.yaml.document import read_text
from bt_mission.commands.edit import patches
from bt_mission.commands.edit.source import Edit, Edits, PatchError, applied
from bt_mission.commands.edit.spans import Path, read_spans
from sim.world.world import Box, Cylinder, SlipperyPatch, Spawn, Wall, WorldPart, Zone

SPAWN = "spawn"
SECTIONS: Mapping[str, tuple[str, type[WorldPart]]] = {
    "walls": ("wall", Wall),
    "boxes": ("box", Box),
    "cylinders": ("cylinder", Cylinder),
    "zones": ("zone", Zone),
    "slippery": ("slippery patch", SlipperyPatch),
    SPAWN: ("start", Spawn),
}
"""What can be on a map: the key of its list, its name for people, and its form."""

_NEW = {
    "boxes": "x: {x}, y: {y}, size: [0.3, 0.3, 0.3]",
    "cylinders": "x: {x}, y: {y}, radius: 0.15",
    "zones": "x: {x}, y: {y}, radius: 0.4",
    "slippery": "x: {x}, y: {y}, radius: 0.4",
}
_UNITS = {"yaw": "deg"}
_NOT_MOVED = "this cannot be moved on the map; edit the text"
_WITHOUT_UNIT = ("name", "colour", "friction", "motion")


def world_forms() -> list[dict[str, Any]]:
    """Return the fields of what can be on a map, with units and ranges."""
    return [
        {"section": section, "name": name, "fields": _fields(model)}
        for section, (name, model) in SECTIONS.items()
    ]


def _fields(model: type[WorldPart]) -> list[dict[str, Any]]:
    properties = model.model_json_schema()["properties"]
    required = [field.alias or name for name, field in model.model_fields.items()]
    rows = []
    for name in required:
        facts = properties[name]
        unit = "" if name in _WITHOUT_UNIT else _UNITS.get(name, "m")
        rows.append(
            {
                "name": name,
                "words": _words(facts),
                "text": "",
                "unit": unit,
                "default": "" if facts.get("default") is None else str(facts["default"]),
                "is_required": name in model.model_json_schema().get("required", ()),
            }
        )
    return rows


def _words(facts: Mapping[str, Any]) -> str:
    """Return the range of a number, and of each of several numbers, as text."""
    for inner in facts.get("anyOf", ()):
        if inner.get("type") != "null":
            return _words(inner)
    if items := facts.get("prefixItems"):
        return f"[{', '.join('0.5' for _ in items)}]: {len(items)} numbers {_words(items[0])}"
    low, high = facts.get("minimum"), facts.get("maximum", facts.get("exclusiveMaximum"))
    return "" if low is None else f"from {low:g} to {high:g}"


def values_of(text: str, path: Path) -> dict[str, str]:
    """Return what is written in the fields of a thing on a map."""
    span = read_spans(text).find(path)
    parts = {} if span is None or span.kind != "map" else span.parts
    return {
        key: part.text if part.kind == "scalar" else text[part.start : part.end]
        for key, part in parts.items()
    }


def add_thing(text: str, section: str, begin: Sequence[float], end: Sequence[float]) -> Edits:
    """Put a new thing on the map at a place, a wall between two places; or move the start.

    Raises:
        PatchError: The text has no place for it.
    """
    if section == SPAWN:
        return _moved_to(text, (SPAWN,), {"x": end[0], "y": end[1]})
    data = read_text(text).data
    things = data.get(section) if isinstance(data, Mapping) else None
    listed = things if isinstance(things, list) else ()
    taken = [each.get("name") for each in listed if isinstance(each, Mapping)]
    word = SECTIONS[section][0]
    name = next(free for n in count(1) if (free := f"{word} {n}") not in taken)
    if section == "walls":
        if begin == end:
            raise PatchError("a wall needs two places")
        shape = f"from: {_pair(begin)}, to: {_pair(end)}"
    else:
        shape = _NEW[section].format(x=_number(end[0]), y=_number(end[1]))
    return patches.append(text, section, f"{{name: {name}, {shape}}}")


def move_thing(text: str, path: Path, by: Sequence[float]) -> Edits:
    """Move a thing on the map by a way, m. Raises PatchError."""
    document = read_text(text)
    data: Any = document.data if document.has(*path) else None
    for key in path if document.has(*path) else ():
        data = data[key]
    thing: Mapping[str, Any] = data if isinstance(data, Mapping) else {}
    moved: dict[str, Any] = {}
    for axis, key in enumerate(("x", "y")):
        if key in thing or path == (SPAWN,):
            moved[key] = _shifted(thing.get(key, 0), by[axis])
    for key in ("from", "to", "centre"):
        if key in thing:
            place = thing[key] if isinstance(thing[key], list) else []
            if len(place) != len(by):
                raise PatchError(_NOT_MOVED)
            moved[key] = [_shifted(value, way) for value, way in zip(place, by, strict=True)]
    if not moved:
        raise PatchError(_NOT_MOVED)
    return _moved_to(text, path, moved)


def _shifted(value: Any, by: float) -> float:
    if type(value) not in (int, float):
        raise PatchError(_NOT_MOVED)
    return float(value) + by


def _moved_to(text: str, path: Path, values: Mapping[str, Any]) -> Edits:
    after = text
    for key, value in values.items():
        written = _pair(value) if isinstance(value, list) else _number(value)
        keys, above = ((*path, key), ()) if path == (SPAWN,) else ((key,), path)
        after = applied(after, patches.set_field(after, above, [str(k) for k in keys], written))
    return _difference(text, after)


def _difference(before: str, after: str) -> Edits:
    """Return the one edit between two texts."""
    start, most = 0, min(len(before), len(after))
    while start < most and before[start] == after[start]:
        start += 1
    same = 0
    while same < most - start and before[-1 - same] == after[-1 - same]:
        same += 1
    if before == after:
        return ()
    return (Edit(start, len(before) - same, after[start : len(after) - same]),)


def _number(value: float) -> str:
    return f"{round(value, 3) + 0.0:g}"


def _pair(values: Sequence[float]) -> str:
    return f"[{', '.join(map(_number, values))}]"
