"""Messages that are sent again and again, kept as bytes of which only the numbers change.

To serialize a message, rclpy walks through all of its fields, each time; an odometry message has
ninety. Here it does so once, and after that the numbers are put into their places. A place is found
by giving the field a number that is nowhere else, and looking where it turns up.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from operator import attrgetter
from types import SimpleNamespace
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
    count: int | None = None

    @property
    def end(self) -> int:
        """The place after it."""
        return self.at + struct.calcsize(self.form) * (self.count or 1)


class MessageTemplate:
    """One message, of which some numbers and the stamps change.

    Args:
        message: As it is to be sent, but for the numbers.
        stamp: The Time that stands wherever the message has a stamp.
        parts: Which numbers: the message, or messages within it, each with the dotted names of
            fields that are floats or lists of floats.
        serialize: Gives the bytes of a message.
        unused: So many bytes at the end are none of the message: where it ends with an empty list
            of doubles, rclpy counts the room that would align their first.

    Raises:
        ValueError: For a field that does not turn up in the bytes exactly once.
    """

    def __init__(
        self,
        message: Any,
        stamp: Any,
        parts: Sequence[tuple[Any, Iterable[str]]],
        serialize: Serialize,
        unused: int = 0,
    ) -> None:
        self.numbers = [SimpleNamespace() for _ in parts]
        """What is filled in: of each part the fields that were named, and nothing else."""
        self._stamp = stamp
        self._stamps = _stamps(message, stamp, serialize)
        self._writes: list[tuple[Callable[..., None], int, Callable[[Any], Any], Any]] = []
        for (part, names), numbers in zip(parts, self.numbers, strict=True):
            fields = [_find(message, part, name, serialize) for name in names]
            for field in fields:
                _grow(numbers, field, attrgetter(field.name)(part))
            for run in _runs(sorted(fields, key=lambda field: field.at)):
                getter, form = _reader(run)
                self._writes.append((struct.Struct(form).pack_into, run[0].at, getter, numbers))
        self._data = bytearray(serialize(message)[: -unused or None])

    def packed(self) -> bytes:
        """The message with the numbers and the stamp as they are now."""
        data = self._data
        sec, nanosec = self._stamp.sec, self._stamp.nanosec
        for at in self._stamps:
            _STAMP.pack_into(data, at, sec, nanosec)
        for pack_into, at, values, numbers in self._writes:
            pack_into(data, at, *values(numbers))
        return bytes(data)


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
        data, count = serialize(message), None
        setattr(owner, last, before)
    else:
        count, first = len(before), before[0]
        before[0] = _PROBE
        data = serialize(message)
        before[0] = first
    found = [
        (at, form) for form in ("d", "f") for at in _all(data, struct.pack(f"<{form}", _PROBE))
    ]
    if len(found) != 1:
        raise ValueError(f"{name} stands in {len(found)} places of a {type(message).__name__}")
    ((at, form),) = found
    return _Field(name, at, form, count)


def _all(data: bytes, pattern: bytes) -> Iterator[int]:
    at = data.find(pattern)
    while at >= 0:
        yield at
        at = data.find(pattern, at + 1)


def _grow(numbers: SimpleNamespace, field: _Field, value: Any) -> None:
    *path, last = field.name.split(".")
    for name in path:
        if not hasattr(numbers, name):
            setattr(numbers, name, SimpleNamespace())
        numbers = getattr(numbers, name)
    setattr(numbers, last, value if field.count is None else list(value))


def _runs(fields: Iterable[_Field]) -> Iterator[list[_Field]]:
    """Neighbours of one kind, which are written together."""
    run: list[_Field] = []
    for field in fields:
        is_next = run and field.at == run[-1].end and field.form == run[-1].form
        if run and (not is_next or field.count is not None or run[-1].count is not None):
            yield run
            run = []
        run.append(field)
    if run:
        yield run


def _reader(run: list[_Field]) -> tuple[Callable[[Any], Any], str]:
    """What reads the numbers of a run, and their form."""
    form = run[0].form
    if run[0].count is not None:
        return attrgetter(run[0].name), f"<{run[0].count}{form}"
    if len(run) == 1:
        read = attrgetter(run[0].name)
        return lambda numbers: (read(numbers),), f"<{form}"
    return attrgetter(*(field.name for field in run)), f"<{len(run)}{form}"
