"""Messages that are sent again and again, kept as bytes of which only the numbers change.

To serialize a message, rclpy walks through all of its fields, each time; an odometry message has
ninety. Here it does so once, and after that the numbers are put into their places. A place is found
by giving the field a number that is nowhere else, and looking where it turns up.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from operator import attrgetter, itemgetter
from typing import Any

Serialize = Callable[[Any], bytes]

_PROBE = struct.unpack("<f", b"\x5d\xc3\xb7\x6e")[0]  # exact as a double, too
_PROBE_STAMP = (0x5DC3B76E, 0x1A2B3C4D)
_STAMP = struct.Struct("<iI")


@dataclass(frozen=True)
class _Field:
    """A float in the bytes, or a list of them: `form` is ``f`` or ``d``."""

    name: str
    at: int
    form: str
    count: int = 1


class MessageTemplate:
    """One message, of which some numbers and the stamps change.

    Args:
        message: The message to send, except for the numbers.
        stamp: The Time of each stamp in the message.
        parts: Which numbers: the message, or messages within it, each with the dotted names of
            fields that are floats or lists of floats, in the order in which they are sent.
        serialize: Gives the bytes of a message.
        unused: The number of bytes at the end that do not belong to the message: if it ends with an
            empty list of doubles, rclpy adds the padding of its first element.

    Raises:
        ValueError: For a field that does not turn up in the bytes exactly once, or in that order.
    """

    def __init__(
        self,
        message: Any,
        stamp: Any,
        parts: Sequence[tuple[Any, Iterable[str]]],
        serialize: Serialize,
        unused: int = 0,
    ) -> None:
        self._stamp = stamp
        fields = [_find(message, part, name, serialize) for part, names in parts for name in names]
        if fields != sorted(fields, key=attrgetter("at")):
            raise ValueError(f"fields of a {type(message).__name__} in another order than it has")
        data = serialize(message)[: -unused or None]
        changing: list[tuple[int, str, int, int | None]] = [
            (at, "iI", 2, None) for at in _stamps(message, stamp, serialize)
        ]
        first = 0
        for field in fields:
            form = f"{field.count}{field.form}"
            changing.append((field.at, form, field.count, first))
            first += field.count
        self._count = first
        self._row = self._lay_out(data, sorted(changing, key=itemgetter(0)))

    def _lay_out(
        self, data: bytes, changing: Iterable[tuple[int, str, int, int | None]]
    ) -> struct.Struct:
        """Find the place of everything among the arguments of the whole message."""
        self._arguments: list[Any] = []
        """The constant parts, and placeholders of the others."""
        self._stamp_places: list[int] = []
        self._number_places: list[tuple[slice, slice]] = []
        """Places of numbers among the arguments, and which numbers."""
        arguments, form, end = self._arguments, "<", 0
        for at, letter, count, first in changing:
            if at > end:
                arguments.append(data[end:at])
                form += f"{at - end}s"
            place = len(arguments)
            if first is None:
                self._stamp_places.append(place)
            else:
                self._add_numbers(slice(place, place + count), slice(first, first + count))
            arguments += [0] * count
            form += letter
            end = at + struct.calcsize(f"<{letter}")
        arguments.append(data[end:])
        return struct.Struct(f"{form}{len(data) - end}s")

    def _add_numbers(self, place: slice, which: slice) -> None:
        places = self._number_places
        if places and places[-1][0].stop == place.start and places[-1][1].stop == which.start:
            place = slice(places[-1][0].start, place.stop)
            which = slice(places.pop()[1].start, which.stop)
        places.append((place, which))

    def packed(self, *numbers: float) -> bytes:
        """Return the message with these numbers, and the present stamp.

        Raises:
            ValueError: Their number is not that of the fields.
        """
        if len(numbers) != self._count:
            raise ValueError(f"expected {self._count} numbers, got {len(numbers)}")
        arguments, sec, nanosec = self._arguments, self._stamp.sec, self._stamp.nanosec
        for at in self._stamp_places:
            arguments[at], arguments[at + 1] = sec, nanosec
        for place, which in self._number_places:
            arguments[place] = numbers[which]
        return self._row.pack(*arguments)


def _stamps(message: Any, stamp: Any, serialize: Serialize) -> list[int]:
    before = stamp.sec, stamp.nanosec
    stamp.sec, stamp.nanosec = _PROBE_STAMP
    data = serialize(message)
    stamp.sec, stamp.nanosec = before
    return list(_all(data, _STAMP.pack(*_PROBE_STAMP)))


def _find(message: Any, part: Any, name: str, serialize: Serialize) -> _Field:
    path, _, last = name.rpartition(".")
    owner = attrgetter(path)(part) if path else part
    before = getattr(owner, last)
    if isinstance(before, float):
        setattr(owner, last, _PROBE)
        data, count = serialize(message), 1
        setattr(owner, last, before)
    else:
        count, first = len(before), before[0]
        before[0] = _PROBE
        data = serialize(message)
        before[0] = first
    matches = [
        (at, form) for form in ("d", "f") for at in _all(data, struct.pack(f"<{form}", _PROBE))
    ]
    if len(matches) != 1:
        raise ValueError(f"{name} is in {len(matches)} places of a {type(message).__name__}")
    ((at, form),) = matches
    return _Field(name, at, form, count)


def _all(data: bytes, pattern: bytes) -> Iterator[int]:
    at = data.find(pattern)
    while at >= 0:
        yield at
        at = data.find(pattern, at + 1)
