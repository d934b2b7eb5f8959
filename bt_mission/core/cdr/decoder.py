"""Serialized messages (CDR) as plain values, by the definitions that a file brings along.

Pure: no ROS, no generated classes, so any message of any file can be read. A message becomes a
dict (:class:`DecodedMessage`); an array of numbers a NumPy array; other arrays and sequences become
lists.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from bt_mission.core.cdr.definitions import SEPARATOR
from bt_mission.core.errors import BtMissionError

Step = Callable[[bytes, int], tuple[Any, int]]
"""Reads a value at a place in the data, counted from its head; gives it and the place after it."""

_FORMATS = {
    "bool": "?",
    "byte": "B",
    "char": "B",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
    "float32": "f",
    "float64": "d",
}
_FIELD = re.compile(
    r"^\s*(?P<type>[A-Za-z][\w/]*)(?:<=\d+)?(?P<array>\[(?P<most><=)?(?P<size>\d*)\])?"
    r"\s+(?P<name>[A-Za-z]\w*)\s*(?P<constant>=)?"
)
HEAD = 4
"""Bytes that say how the rest is written."""


class DecodingError(BtMissionError):
    """A message that its definition does not fit."""


@dataclass(frozen=True)
class Field:
    """A field of a message; `size` is None for one value, -1 for any number of them."""

    name: str
    type: str
    size: int | None


def parse(type_name: str, definition: str) -> dict[str, list[Field]]:
    """The fields of each message of a definition, by ``package/Name``; the first is "".

    Types are ``package/Name``, too, or basic ones.
    """
    package = type_name.partition("/")[0]
    found: dict[str, list[Field]] = {}
    for part in definition.split(f"\n{SEPARATOR}\n"):
        first, _, rest = part.partition("\n")
        name, text = "", part
        if first.startswith("MSG: "):
            name, text = _short(first.removeprefix("MSG: ").strip()), rest
        here = name.partition("/")[0] or package
        found[name] = [field for line in text.splitlines() for field in _fields(line, here)]
    return found


def _fields(line: str, package: str) -> list[Field]:
    match = _FIELD.match(line)
    if match is None or match["constant"]:
        return []
    kind = match["type"]
    if kind not in _FORMATS and kind not in ("string", "wstring"):
        kind = _short(kind) if "/" in kind else _local(kind, package)
    size = None
    if match["array"]:
        size = -1 if match["most"] or not match["size"] else int(match["size"])
    return [Field(match["name"], kind, size)]


def _local(name: str, package: str) -> str:
    return "std_msgs/Header" if name == "Header" else f"{package}/{name}"


def _short(name: str) -> str:
    """`package/Name` of `package/msg/Name`."""
    return f"{name.partition('/')[0]}/{name.rpartition('/')[2]}"


class DecodedMessage(dict[str, Any]):
    """The values of a message by the names of its fields, which are attributes, too."""

    __slots__ = ()
    __getattr__ = dict.__getitem__


class Decoder:
    """Reads messages of one type.

    :param type_name: such as ``nav_msgs/msg/Odometry``.
    :param definition: its text and those of what it is made of (``ros2msg``).
    """

    def __init__(self, type_name: str, definition: str) -> None:
        self.type_name = type_name
        self._specs = parse(type_name, definition)
        self._steps: dict[str, Step] = {}

    @property
    def has_known_length(self) -> bool:
        """Does ROS know how long such a message is before it is serialized?

        It does not for sequences, other than of small numbers: an empty one is reckoned with the
        room that keeps its first element in its place, were there one.
        """
        sizes = {kind: struct.calcsize(form) for kind, form in _FORMATS.items()}
        return not any(
            field.size == -1 and sizes.get(field.type, 8) > 4
            for fields in self._specs.values()
            for field in fields
        )

    def decode(self, data: bytes) -> DecodedMessage:
        """Give the values of a message by the names of its fields.

        :raises DecodingError: when the definition does not fit it.
        """
        return self._read(data)[0]

    def trim(self, data: bytes) -> bytes:
        """Take away what follows a message; rclpy leaves room where the length is not known.

        :raises DecodingError: when the definition does not fit it.
        """
        return data[: self._read(data)[1]]

    def _read(self, data: bytes) -> tuple[DecodedMessage, int]:
        try:
            order = "<" if data[1] & 1 else ">"
            if order not in self._steps:
                self._steps[order] = _Compiler(self._specs, order).message("")
            value, end = self._steps[order](data, HEAD)
        except (struct.error, IndexError, ValueError, KeyError, RecursionError) as error:
            raise DecodingError(
                f"a message of type {self.type_name} cannot be read: {error}"
            ) from error
        else:
            return value, end


class _Compiler:
    """Makes functions that read, for one order of bytes."""

    def __init__(self, specs: Mapping[str, list[Field]], order: str) -> None:
        self._specs = specs
        self._order = order
        self._known: dict[str, Step] = {}

    def message(self, name: str) -> Step:
        if name in self._known:
            return self._known[name]
        if name not in self._specs:
            raise KeyError(f"it has no definition of {name}")
        fields = [(field.name, self._field(field)) for field in self._specs[name]]

        def read(data: bytes, at: int) -> tuple[Any, int]:
            values = DecodedMessage()
            for key, step in fields:
                values[key], at = step(data, at)
            return values, at

        def read_nothing(_: bytes, at: int) -> tuple[Any, int]:
            return DecodedMessage(), at + 1  # a message without fields is sent with one byte

        self._known[name] = read if fields else read_nothing
        return self._known[name]

    def _field(self, field: Field) -> Step:
        one = self._one(field.type)
        if field.size is None:
            return one
        many = self._numbers(field.type) if field.type in _FORMATS else _several(one)
        if field.size >= 0:
            size = field.size
            return lambda data, at: many(data, at, size)
        length = self._one("uint32")

        def sequence(data: bytes, at: int) -> tuple[Any, int]:
            count, at = length(data, at)
            return many(data, at, count)

        return sequence

    def _one(self, kind: str) -> Step:
        if kind in _FORMATS:
            return self._number(_FORMATS[kind])
        if kind == "string":
            return self._string()
        if kind == "wstring":
            raise ValueError("wide strings are not supported")
        return self.message(kind)

    def _number(self, form: str) -> Step:
        one = struct.Struct(self._order + form)
        size, unpack = one.size, one.unpack_from

        def read(data: bytes, at: int) -> tuple[Any, int]:
            at += -(at - HEAD) % size
            return unpack(data, at)[0], at + size

        return read

    def _string(self) -> Step:
        length = self._number("I")

        def read(data: bytes, at: int) -> tuple[Any, int]:
            count, at = length(data, at)
            end = at + count
            if end > len(data):
                raise ValueError("a text is longer than the message")
            return data[at : end - 1].decode(errors="replace") if count else "", end

        return read

    def _numbers(self, kind: str) -> Callable[[bytes, int, int], tuple[Any, int]]:
        form = np.dtype(self._order + _FORMATS[kind])
        size = form.itemsize

        def read(data: bytes, at: int, count: int) -> tuple[Any, int]:
            if count == 0:
                return np.empty(0, form), at
            at += -(at - HEAD) % size
            return np.frombuffer(data, form, count, at), at + count * size

        return read


def _several(one: Step) -> Callable[[bytes, int, int], tuple[Any, int]]:
    def read(data: bytes, at: int, count: int) -> tuple[Any, int]:
        if count > len(data):
            raise ValueError("a sequence is longer than the message")
        values = []
        for _ in range(count):
            value, at = one(data, at)
            values.append(value)
        return values, at

    return read
