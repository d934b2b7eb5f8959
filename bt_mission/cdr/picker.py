"""A few fields of messages that come again and again, without decoding the rest of them.

Most messages of a topic are laid out alike: their texts and the lengths of their sequences stay the
same, so every number stays in its place. Where the places are is found once, by walking through a
message; each message after that is compared with it in what decides the places, and the numbers
are read in one go.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from bt_mission.cdr.decoder import FORMATS, HEAD, Decoder, DecodingError, byte_order
from bt_mission.cdr.definitions import Field

MOST_LAYOUTS = 8
"""The number of layouts that are kept: several nodes publish on `tf`, each with its frames, in
turns.
"""

Texts = Mapping[str, str]
Choose = Callable[[Texts], Sequence[str]]
"""Takes a message's texts; returns the paths of the wanted numbers, in the message's order."""


@dataclass(frozen=True, slots=True)
class Picked:
    """Numbers of a message, and all of its texts by their paths."""

    numbers: tuple[Any, ...]
    texts: Texts


@dataclass(frozen=True, slots=True)
class _Layout:
    """The places of the numbers in messages that agree in certain bytes."""

    length: int
    decisive: tuple[tuple[int, int, bytes], ...]
    row: struct.Struct
    texts: Texts

    def fits(self, data: bytes) -> bool:
        if len(data) != self.length:
            return False
        for start, end, known in self.decisive:  # noqa: SIM110 - a generator takes twice as long
            if data[start:end] != known:
                return False
        return True


class Picker:
    """Reads some numbers of messages of one type.

    Args:
        decoder: The decoder of the type.
        choose: Which ones: their paths, such as ``transforms.0.transform.translation.x``; or a
            function that gives them by the texts of the message, which are no numbers but part of
            its layout.
    """

    def __init__(self, decoder: Decoder, choose: Choose | Sequence[str]) -> None:
        self._decoder = decoder
        self._choose: Choose = choose if callable(choose) else lambda _: choose
        self._layouts: list[_Layout] = []

    def pick(self, data: bytes) -> Picked:
        """Return the numbers of a serialized message, in order, and its texts.

        Raises:
            DecodingError: The type does not fit the message, or has no such number.
        """
        for layout in self._layouts:
            if layout.fits(data):
                break
        else:
            layout = self._learn(data)
            self._layouts = [layout, *self._layouts[: MOST_LAYOUTS - 1]]
        return Picked(layout.row.unpack_from(data), layout.texts)

    def _learn(self, data: bytes) -> _Layout:
        try:
            walk = _Walk(self._decoder.specs, data, byte_order(data))
            walk.whole()
            row = _row(walk, self._choose(walk.texts), byte_order(data))
        except (struct.error, IndexError, ValueError, KeyError, RecursionError) as error:
            raise DecodingError(
                f"invalid message of type {self._decoder.type_name}: {error}"
            ) from error
        decisive = tuple((start, end, data[start:end]) for start, end in _merged(walk.decisive))
        return _Layout(len(data), decisive, row, walk.texts)


def _row(walk: _Walk, paths: Sequence[str], order: str) -> struct.Struct:
    """Return what reads numbers at their places, and skips what lies between."""
    at, form = 0, order
    for path in paths:
        place, letter = walk.places[path]
        if place < at:
            raise ValueError(f"{path} comes before what is asked for ahead of it")
        form += f"{place - at}x{letter}"
        at = place + struct.calcsize(letter)
    return struct.Struct(form)


def _merged(spans: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    merged: list[tuple[int, int]] = []
    for start, end in spans:
        if merged and start - merged[-1][1] < HEAD:  # what aligns the next length lies between
            merged[-1] = merged[-1][0], end
        else:
            merged.append((start, end))
    return merged


@dataclass
class _Walk:
    """Walks through one message, and notes the places of its numbers and what determines them."""

    specs: Mapping[str, Sequence[Field]]
    data: bytes
    order: str
    places: dict[str, tuple[int, str]] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)
    decisive: list[tuple[int, int]] = field(default_factory=lambda: [(0, HEAD)])

    def whole(self) -> None:
        """Walk through all of it."""
        if self.message("", "", HEAD) > len(self.data):
            raise ValueError("it ends too early")

    def message(self, name: str, path: str, at: int) -> int:
        """Walk through a message at a place. Return the next place."""
        fields = self.specs[name]
        if not fields:
            return at + 1  # a message without fields is sent with one byte
        for part in fields:
            at = self._field(part, f"{path}.{part.name}" if path else part.name, at)
        return at

    def _field(self, field: Field, path: str, at: int) -> int:
        if field.size is None:
            return self._walk_value(field.type, path, at)
        count = field.size
        if count < 0:
            count, at = self._length(at)
            if count > len(self.data):
                raise ValueError("a sequence is longer than the message")
        if field.type in FORMATS:
            size = struct.calcsize(FORMATS[field.type])
            return at + (-(at - HEAD) % size + count * size if count else 0)
        for index in range(count):
            at = self._walk_value(field.type, f"{path}.{index}", at)
        return at

    def _walk_value(self, kind: str, path: str, at: int) -> int:
        if kind in FORMATS:
            size = struct.calcsize(FORMATS[kind])
            at += -(at - HEAD) % size
            self.places[path] = at, FORMATS[kind]
            return at + size
        if kind != "string":
            return self.message(kind, path, at)
        count, start = self._length(at)
        end = start + count
        if end > len(self.data):
            raise ValueError("a string is longer than the message")
        self.decisive.append((start, end))
        self.texts[path] = self.data[start : end - 1].decode(errors="replace") if count else ""
        return end

    def _length(self, at: int) -> tuple[int, int]:
        at += -(at - HEAD) % 4
        self.decisive.append((at, at + 4))
        (count,) = struct.unpack_from(f"{self.order}I", self.data, at)
        return count, at + 4
