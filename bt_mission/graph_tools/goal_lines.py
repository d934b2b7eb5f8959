"""The life of a goal sent by hand, as lines for people and as objects for programs."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any, TextIO

from bt_mission.goals.goal import Goal
from bt_mission.graph_tools.goal_request import GoalResult
from bt_mission.graph_tools.interface_description import InterfaceDescription
from bt_mission.graph_tools.values import as_json, flat, plain, short

SHOWN = 16
LONG = 60
"""Characters of a list beyond which its items stand one below the other."""


def said(message: Any, units: Mapping[str, str]) -> str:
    """A message on one line: ``current_angle 12.5 deg, remaining_angle 77.5 deg``."""
    fields = flat(plain(message, SHOWN))
    return ", ".join(f"{name} {short(value)}{_unit(units, name)}" for name, value in fields)


def _unit(units: Mapping[str, str], name: str) -> str:
    unit = units.get(name, "")
    return f" {unit}" if unit else ""


def table(message: Any, about: InterfaceDescription, part: str) -> list[str]:
    """A message with a line for each field, names of codes included."""
    of_part = about.part(part)
    units = of_part.units()
    rows = list(flat(plain(message, SHOWN)))
    width = max((len(name) for name, _ in rows), default=0)
    lines = []
    for name, value in rows:
        known = of_part.section.name_of(name, value)
        if isinstance(value, list) and len(short(value)) > LONG:
            lines += [f"  {name}", *(f"    {short(item)}" for item in value)]
            continue
        words = f"{short(value)}{_unit(units, name)}{f'  ({known})' if known else ''}"
        lines.append(f"  {name:{width}}  {words}")
    return lines


class GoalLines:
    """A line for each thing that happens; feedback whenever it has changed.

    :param stream: where to write.
    :param about: the action's type.
    """

    def __init__(self, stream: TextIO, about: InterfaceDescription) -> None:
        self._stream = stream
        self._about = about
        self._units = about.part("feedback").units()
        self._last = ""

    def waiting(self, action: str) -> None:
        """There is no server yet."""
        self._line(f"waiting for a server of {action}")

    def accepted(self, goal: Goal) -> None:
        """The server accepted it."""
        self._line(f"goal {goal.short_id} accepted")

    def feedback(self, message: Any, since_s: float) -> None:
        """Feedback came."""
        text = said(message, self._units)
        if text != self._last:
            self._last = text
            self._line(f"{since_s:9.2f} s  {text}")

    def canceling(self, why: str) -> None:
        """Its cancel has been asked for."""
        self._line(f"canceling: {why}")

    def refused(self) -> None:
        """The server refused to cancel."""
        self._line("the server refused to cancel; asking again each second")

    def ended(self, end: GoalResult, since_s: float) -> None:
        """It has ended."""
        for line in end_lines(end, self._about, since_s):
            self._line(line)

    def _line(self, text: str) -> None:
        print(text, file=self._stream, flush=True)


def end_lines(end: GoalResult, about: InterfaceDescription, since_s: float) -> list[str]:
    """How a goal ended, and its result."""
    if end.result is None:
        return [end.reason]
    return [f"{end.reason} after {since_s:.2f} s", *table(end.result, about, "result")]


class GoalObjects:
    """One JSON object a line: ``accepted``, ``feedback``, ``canceling``, ``refused``, ``ended``."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._goal = ""

    def waiting(self, action: str) -> None:
        """People are told; programs look at what happens."""
        sys.stderr.write(f"waiting for a server of {action}\n")

    def accepted(self, goal: Goal) -> None:
        """The server accepted it."""
        self._goal = goal.id.hex()
        self._write("accepted")

    def feedback(self, message: Any, since_s: float) -> None:
        """Feedback came."""
        self._write("feedback", since_s=round(since_s, 6), feedback=plain(message))

    def canceling(self, why: str) -> None:
        """Its cancel has been asked for."""
        self._write("canceling", why=why)

    def refused(self) -> None:
        """The server refused to cancel."""
        self._write("refused")

    def ended(self, end: GoalResult, since_s: float) -> None:
        """It has ended."""
        result = None if end.result is None else plain(end.result)
        self._write(
            "ended",
            status=str(end.how),
            reason=end.reason,
            since_s=round(since_s, 6),
            result=result,
        )

    def _write(self, event: str, **more: Any) -> None:
        goal = {"goal": self._goal} if self._goal else {}
        print(as_json({"event": event, **goal, **more}), file=self._stream, flush=True)
