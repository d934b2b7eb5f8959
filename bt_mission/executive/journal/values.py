"""Values of variables as JSON: plain ones as they are, messages by way of the caller."""

from __future__ import annotations

import random
import struct
from collections.abc import Callable
from typing import Any

from bt_mission.core.errors import BtMissionError

Pack = Callable[[Any], Any]
"""Gives JSON for a message; None for what is none."""
Unpack = Callable[[Any], Any]


def encode(value: Any, pack: Pack) -> Any:
    """A value as JSON. What cannot be said in it is named, and missed only when it is read."""
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, list | tuple):
        return [encode(part, pack) for part in value]
    if isinstance(value, bytes):
        return {"bytes": value.hex()}
    packed = pack(value)
    return {"lost": type(value).__name__} if packed is None else {"message": packed}


def decode(name: str, data: Any, unpack: Unpack) -> Any:
    """The value of the variable ``name``.

    Raises:
        BtMissionError: For one that could not be written.
    """
    if isinstance(data, list):
        return [decode(name, part, unpack) for part in data]
    if not isinstance(data, dict):
        return data
    if "bytes" in data:
        return bytes.fromhex(data["bytes"])
    if "lost" in data:
        raise BtMissionError(f"the variable '{name}' was a {data['lost']}, which no journal keeps")
    return unpack(data["message"])


def pack_generator(generator: random.Random) -> list[Any]:
    """The state of a random generator."""
    version, state, gauss = generator.getstate()
    return [version, struct.pack(f"<{len(state)}I", *state).hex(), gauss]


def unpack_generator(generator: random.Random, data: list[Any]) -> None:
    """Put a random generator into that state."""
    version, state, gauss = data
    raw = bytes.fromhex(state)
    generator.setstate((version, struct.unpack(f"<{len(raw) // 4}I", raw), gauss))
