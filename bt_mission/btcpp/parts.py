"""Data as a YAML file would hold it, each part with its place in the XML file."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from bt_mission.btcpp.elements import Attribute
from bt_mission.core.yaml.composer import Place

At = tuple[int, int]
"""Line and column, from 1."""


@dataclass(frozen=True)
class LocatedValue:
    """A value, and where it stands."""

    data: Any
    place: Place


Entry = tuple[str, At, LocatedValue]
"""A key, where it stands, and its value."""


def scalar(value: Any, at: At) -> LocatedValue:
    """Return a single value."""
    return LocatedValue(value, Place(*at))


def text(value: str, attribute: Attribute) -> LocatedValue:
    """Return a text that is the value of an attribute, so that columns in it can be told."""
    return LocatedValue(value, Place(attribute.value_line, attribute.value_column, text=value))


def mapping(at: At, entries: Iterable[Entry]) -> LocatedValue:
    """Return a mapping; of two entries with one key the later counts."""
    data: dict[str, Any] = {}
    keys: dict[str, At] = {}
    parts: dict[str, Place] = {}
    for key, key_at, part in entries:
        data[key], keys[key], parts[key] = part.data, key_at, part.place
    return LocatedValue(data, Place(*at, keys=keys, parts=parts))


def sequence(at: At, items: Iterable[LocatedValue]) -> LocatedValue:
    """Return a list."""
    kept = list(items)
    return LocatedValue([one.data for one in kept], Place(*at, parts=[one.place for one in kept]))


def moved(place: Place, line: int, column: int) -> Place:
    """Return a place within a text as a place in the file that the text begins at, on one line."""
    parts: dict[str, Place] | list[Place] | None = None
    if isinstance(place.parts, dict):
        parts = {key: moved(part, line, column) for key, part in place.parts.items()}
    elif isinstance(place.parts, list):
        parts = [moved(part, line, column) for part in place.parts]
    keys = {key: (line, column + at[1] - 1) for key, at in (place.keys or {}).items()}
    return Place(
        line,
        column + place.column - 1,
        keys=keys if place.keys is not None else None,
        parts=parts,
        text=place.text,
    )
