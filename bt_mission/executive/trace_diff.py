"""The first difference between two traces."""

from __future__ import annotations

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any

from bt_mission.base.text import escape_control, seconds
from bt_mission.executive.events.log import line_of
from bt_mission.executive.stored_trace import StoredTrace

Event = dict[str, Any]

LEADING_UP = 4
"""The number of events before the difference that are shown; poses do not count."""


@dataclass(frozen=True)
class Difference:
    """The place at which two traces differ.

    Args:
        number: The number of equal events before it.
        time_s: Its time since the start, s.
        before: The events before it, a line each.
        first: The event in the first trace; None if that has ended.
        second: The event in the second.
        fields: The differing fields of two events of one kind; a line for each field.
        setting: The differing settings of the runs: mission, world, robot or seed.
    """

    number: int
    time_s: float
    before: tuple[str, ...]
    first: str | None
    second: str | None
    fields: tuple[str, ...]
    setting: tuple[str, ...] = ()

    def __str__(self) -> str:
        lines = [f"different set-up: {line}" for line in self.setting]
        if self.first is None and self.second is None:
            return _joined([*lines, f"all other {self.number} events are the same"])
        same = "no event is" if not self.number else f"the first {self.number} events are"
        lines.append(f"{same} the same; the first difference is at {seconds(self.time_s)}")
        lines += [f"  {line}" for line in self.before]
        for sign, event in (("<", self.first), (">", self.second)):
            lines.append(f"{sign} {event if event is not None else '          (the end)'}")
        return _joined([*lines, *(f"    {line}" for line in self.fields)])


def _joined(lines: Sequence[str]) -> str:
    return "\n".join(map(escape_control, lines))


def first_difference(first: StoredTrace, second: StoredTrace) -> Difference | None:
    """Return where two traces differ, or None if they have the same events at the same times.

    Runs with different settings are compared in the following events. Goal ids derive from the
    seed, and do not count if the seeds differ.
    """
    setting = _fields(first.start, second.start)
    ignored = {"goal"} if first.start.get("seed") != second.start.get("seed") else set()
    events, others = (
        [event for event in trace.events if event is not trace.start] if setting else trace.events
        for trace in (first, second)
    )
    for number, (event, other) in enumerate(zip_longest(events, others)):
        if _without(event, ignored) != _without(other, ignored):
            there = first if event is not None else second
            time_s = min(
                trace.seconds(differing)
                for trace, differing in ((first, event), (second, other))
                if differing is not None
            )
            return Difference(
                number,
                time_s,
                _before(there, events if event is not None else others, number),
                None if event is None else _line(first, event),
                None if other is None else _line(second, other),
                _fields(event, other, ignored),
                setting,
            )
    return Difference(len(events), 0.0, (), None, None, (), setting) if setting else None


def _without(event: Event | None, ignored: AbstractSet[str]) -> Event | None:
    if event is None or not ignored:
        return event
    return {name: value for name, value in event.items() if name not in ignored}


def _before(trace: StoredTrace, events: Sequence[Event], number: int) -> tuple[str, ...]:
    recent = [event for event in events[:number] if event["event"] != "pose"]
    return tuple(_line(trace, event) for event in recent[-LEADING_UP:])


def _line(trace: StoredTrace, event: Event) -> str:
    return f"{seconds(trace.seconds(event)):>10}  {line_of(event)}"


def _fields(
    event: Event | None, other: Event | None, ignored: AbstractSet[str] = frozenset()
) -> tuple[str, ...]:
    if not event or not other or event["event"] != other["event"]:
        return ()
    names = [name for name in dict.fromkeys((*event, *other)) if event.get(name) != other.get(name)]
    names = [name for name in names if name not in ignored]
    return tuple(_field(name, event.get(name), other.get(name)) for name in names)


def _field(name: str, value: Any, other: Any) -> str:
    line = f"{name}: {value} in the first, {other} in the second"
    if isinstance(value, float) and isinstance(other, float):
        line += f" ({other - value:+.3g})"
    return line
