"""Serialized messages (CDR) as plain values, by the definitions that a file brings along.

Pure: no ROS, no generated classes, so any message of any file can be read. A message becomes a
dict (:class:`DecodedMessage`); an array of numbers a NumPy array; other arrays and sequences become
lists. It takes a tenth of the time that rclpy takes to make its objects.

The layout is CDR as DDS sends it (OMG CDR, formal/2021-01-01, 15.3, encoding version 1). The head
has four bytes; the second is the byte order. The fields follow in order, each aligned to its size,
counted from the end of the head. A text is its length with its final zero, and its bytes.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Mapping
from functools import cache, cached_property
from itertools import groupby
from operator import itemgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from bt_mission.base.errors import BtMissionError
from bt_mission.cdr.definitions import Field, definition_of, parse

Take = Callable[[bytes], None]
"""Takes a serialized message."""

Step = Callable[[bytes, int], tuple[Any, int]]
"""Reads a value at a place in the data, counted from its head; returns it and the next place."""

FORMATS = {
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
"""Of :mod:`struct`, by the types of ROS."""
HEAD = 4
"""The bytes of the encoding's header."""

HEADERS = ("std_msgs/Header", "std_msgs/msg/Header")

_ORDERS = {b"\0\0": ">", b"\0\1": "<"}
"""By the first bytes of the head."""


class DecodingError(BtMissionError, ValueError):
    """A message that does not fit its definition."""

    code = "BT-1001"


class DecodedMessage(dict[str, Any]):
    """The values of a message by the names of its fields, which are attributes, too."""

    __slots__ = ()

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...

    else:
        __getattr__ = dict.__getitem__


def _message_class(names: Iterable[str]) -> type[DecodedMessage]:
    """Return the class of messages with these fields.

    A field named like a method of dict hides it.
    """
    hiding = {name: property(itemgetter(name)) for name in names if hasattr(dict, name)}
    return type("DecodedMessage", (DecodedMessage,), hiding) if hiding else DecodedMessage


class Decoder:
    """Reads messages of one type.

    Args:
        type_name: Such as ``nav_msgs/msg/Odometry``.
        definition: Its text and those of its nested types (``ros2msg``).

    Raises:
        DecodingError: A definition cannot be read.
    """

    def __init__(self, type_name: str, definition: str) -> None:
        self.type_name = type_name
        try:
            self.specs = parse(type_name, definition)
            """The fields of the message ("") and of those that it is made of."""
        except ValueError as error:
            raise DecodingError(f"invalid definition of {type_name}: {error}") from error
        self._steps: dict[bytes, Step] = {}
        """By the first bytes of a message."""

    @property
    def has_known_length(self) -> bool:
        """Whether ROS knows the length of such a message before it is serialized.

        It does not for sequences, other than of small numbers: an empty one is counted with the
        padding of its first element, which it lacks.
        """
        sizes = {kind: struct.calcsize(form) for kind, form in FORMATS.items()}
        return not any(
            field.size == -1 and sizes.get(field.type, 8) > 4
            for fields in self.specs.values()
            for field in fields
        )

    @cached_property
    def _stamp_at(self) -> int | None:
        """The place of the stamp of the header, or of that of the first element of a sequence."""
        fields, at = self.specs[""], HEAD
        if fields and fields[0].size == -1 and fields[0].type in self.specs:
            fields, at = self.specs[fields[0].type], HEAD + 4
        has_header = bool(fields) and fields[0].type in HEADERS and fields[0].size is None
        return at if has_header else None

    @property
    def has_header(self) -> bool:
        """Whether such a message begins with a header, or with a sequence of such messages."""
        return self._stamp_at is not None

    def stamp_ns(self, data: bytes) -> int:
        """Return the stamp of a message's header, ns; 0 without one."""
        at = self._stamp_at
        if at is None or len(data) < at + 8 or data[:2] not in _ORDERS:
            return 0
        seconds, nanoseconds = struct.unpack_from(f"{_ORDERS[data[:2]]}iI", data, at)
        return int(seconds * 1_000_000_000 + nanoseconds)

    def decode(self, data: bytes) -> DecodedMessage:
        """Return the values of a message by the names of its fields.

        Raises:
            DecodingError: It does not fit its definition.
        """
        return self._read(data)[0]

    def trimming(self, take: Take, *, has_fixed_shape: bool) -> Take:
        """Return ``take`` for messages of this type without rclpy's additional bytes.

        ``serialize_message`` returns as many bytes as ROS has reserved for a message. That is too
        many for an empty sequence whose elements are aligned to eight, and strict readers refuse
        such messages.

        Args:
            take: Takes the messages.
            has_fixed_shape: Messages of the same length as reckoned have the same true length, so
                each length is looked at once; otherwise each message is read to find its end.
        """
        if self.has_known_length:
            return take
        if not has_fixed_shape:
            return lambda data: take(data[: self._read(data)[1]])
        lengths: dict[int, int] = {}

        def trimmed(data: bytes) -> None:
            length = lengths.get(len(data))
            if length is None:
                length = lengths[len(data)] = self._read(data)[1]
            take(data[:length])

        return trimmed

    def _read(self, data: bytes) -> tuple[DecodedMessage, int]:
        try:
            head = data[:2] if len(data) >= HEAD else b""
            step = self._steps.get(head)
            if step is None:
                step = self._steps[head] = _Compiler(self.specs, byte_order(data)).message("")
            value, end = step(data, HEAD)
        except (struct.error, IndexError, ValueError, KeyError, RecursionError) as error:
            raise DecodingError(f"invalid message of type {self.type_name}: {error}") from error
        else:
            return value, end


def byte_order(data: bytes) -> str:
    """Return the order of bytes in a message, as in :mod:`struct`.

    Raises:
        ValueError: Its head is invalid.
    """
    head = data[:2] if len(data) >= HEAD else b""
    if head not in _ORDERS:
        raise ValueError("no CDR header")
    return _ORDERS[head]


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
            raise KeyError(f"the definition of {name} is missing")
        steps: list[tuple[list[str], Step, bool]] = []
        for size, group in groupby(self._specs[name], _size):
            row = list(group)
            if size:
                steps.append(([field.name for field in row], self._row(row, size), True))
            else:
                steps += (([field.name], self._field(field), False) for field in row)
        message_class = _message_class(key for keys, *_ in steps for key in keys)

        def read(data: bytes, at: int) -> tuple[Any, int]:
            values = message_class()
            for keys, step, is_row in steps:
                value, at = step(data, at)
                values |= zip(keys, value if is_row else (value,), strict=True)
            return values, at

        def read_nothing(data: bytes, at: int) -> tuple[Any, int]:
            if at > len(data):
                raise ValueError("it ends too early")
            return DecodedMessage(), at + 1  # a message without fields is sent with one byte

        self._known[name] = read if steps else read_nothing
        return self._known[name]

    def _row(self, fields: list[Field], size: int) -> Step:
        """Read numbers of one size, such as a quaternion's, in one call."""
        row = struct.Struct(self._order + "".join(FORMATS[field.type] for field in fields))
        length, unpack = row.size, row.unpack_from

        def read(data: bytes, at: int) -> tuple[Any, int]:
            at += -(at - HEAD) % size
            return unpack(data, at), at + length

        return read

    def _field(self, field: Field) -> Step:
        step = self._step_of(field.type)
        if field.size is None:
            return step
        many = self._numbers(field.type) if field.type in FORMATS else _several(step)
        if field.size >= 0:
            size = field.size
            return lambda data, at: many(data, at, size)
        unpack = struct.Struct(self._order + "I").unpack_from

        def sequence(data: bytes, at: int) -> tuple[Any, int]:
            at += -(at - HEAD) % 4
            return many(data, at + 4, unpack(data, at)[0])

        return sequence

    def _step_of(self, kind: str) -> Step:
        if kind in FORMATS:
            return self._number(FORMATS[kind])
        if kind == "string":
            return self._string()
        if kind == "wstring":
            raise ValueError("wide strings are not supported")
        return self.message(kind)

    def _number(self, form: str) -> Step:
        step = struct.Struct(self._order + form)
        size, unpack = step.size, step.unpack_from

        def read(data: bytes, at: int) -> tuple[Any, int]:
            at += -(at - HEAD) % size
            return unpack(data, at)[0], at + size

        return read

    def _string(self) -> Step:
        unpack = struct.Struct(self._order + "I").unpack_from

        def read(data: bytes, at: int) -> tuple[Any, int]:
            at += -(at - HEAD) % 4
            count, at = unpack(data, at)[0], at + 4
            end = at + count
            if end > len(data):
                raise ValueError("a string is longer than the message")
            return data[at : end - 1].decode(errors="replace") if count else "", end

        return read

    def _numbers(self, kind: str) -> Callable[[bytes, int, int], tuple[Any, int]]:
        form = np.dtype(self._order + FORMATS[kind])
        size = form.itemsize

        def read(data: bytes, at: int, count: int) -> tuple[Any, int]:
            if count == 0:
                return np.empty(0, form), at
            at += -(at - HEAD) % size
            return np.frombuffer(data, form, count, at), at + count * size

        return read


def _size(field: Field) -> int:
    """Return the bytes of a field that is a single number; 0 of any other."""
    is_number = field.size is None and field.type in FORMATS
    return struct.calcsize(FORMATS[field.type]) if is_number else 0


def _several(step: Step) -> Callable[[bytes, int, int], tuple[Any, int]]:
    def read(data: bytes, at: int, count: int) -> tuple[Any, int]:
        if count > len(data):
            raise ValueError("a sequence is longer than the message")
        values = []
        for _ in range(count):
            value, at = step(data, at)
            values.append(value)
        return values, at

    return read


@cache
def decoder_of(type_name: str) -> Decoder:
    """Return the decoder of an installed type, such as ``nav_msgs/msg/Odometry``.

    Raises:
        NoDefinitionError: When its definition is not installed.
    """
    return Decoder(type_name, definition_of(type_name))
