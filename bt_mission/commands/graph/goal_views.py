"""The events of goals, as lines, as a drawing in place, or as objects for programs."""

from __future__ import annotations

import sys
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, TextIO

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.style import StyleType
from rich.text import Text

from bt_mission.base.text import escape_control, seconds
from bt_mission.commands.graph.feedback_table import FeedbackTable
from bt_mission.commands.graph.goal_events import (
    CancelRefused,
    CancelRequested,
    FeedbackReceived,
    GoalAccepted,
    GoalEnded,
    GoalEvent,
    GoalOutcome,
    GoalStateChanged,
    ServerAwaited,
)
from bt_mission.commands.graph.interface_description import InterfaceDescription, InterfacePart
from bt_mission.commands.graph.values import SHOWN_ITEMS, as_json, flat, plain, short
from bt_mission.views.terminal.console import EscapingConsole

LONG = 60
"""Characters of a list beyond which its items are in separate lines."""

STYLES = {GoalOutcome.SUCCEEDED: "green", GoalOutcome.CANCELED: "yellow"}
HEAD_STYLES = {ServerAwaited: "dim", GoalAccepted: "bold", CancelRequested: "yellow"}


class GoalView(ABC):
    """Shows events of goals."""

    @abstractmethod
    def show(self, event: GoalEvent) -> None:
        """Show what has happened."""

    def close(self) -> None:  # noqa: B027 - most draw nothing in place
        """Remove what is drawn in place."""


def goal_view_for(
    stream: TextIO, about: InterfaceDescription, goal: Any = None, *, json: bool, plain: bool
) -> GoalView:
    """Choose the view: a drawing on a terminal, lines in a pipe, objects for programs.

    `goal` is the message of our own goal; with `plain`, lines are used also on a terminal.
    """
    if json:
        return GoalObjects(stream)
    console = EscapingConsole(stream)
    if plain or not console.is_terminal or console.is_dumb_terminal:
        return GoalLines(stream, about)
    return GoalPicture(console, about, goal)


class GoalLines(GoalView):
    """Writes a line for each event, and feedback whenever it has changed."""

    def __init__(self, stream: TextIO, about: InterfaceDescription) -> None:
        self._stream = stream
        self._about = about
        self._units = about.part("feedback").units()
        self._last: dict[str, str] = {}

    def show(self, event: GoalEvent) -> None:
        """Write the lines of an event."""
        if isinstance(event, FeedbackReceived):
            text = on_a_line(event.message, self._units)
            if text == self._last.get(event.goal):
                return
            self._last[event.goal] = text
        elif isinstance(event, GoalStateChanged) and event.is_end:
            self._last.pop(event.goal, None)
        for line in event_lines(event, self._about, self._units):
            print(line, file=self._stream, flush=True)


class GoalPicture(GoalView):
    """Draws the newest feedback in place; ends and results of goals stay."""

    def __init__(self, console: Console, about: InterfaceDescription, goal: Any = None) -> None:
        self._console = console
        self._about = about
        self._units = about.part("feedback").units()
        self._table = FeedbackTable(about, goal, console.encoding)
        self._head = Text("")
        self._feedback: Any = None
        self._others: dict[str, str] = {}
        self._live = Live(console=console, auto_refresh=False, transient=True)

    def show(self, event: GoalEvent) -> None:
        """Draw, or write what stays above the picture."""
        match event:
            case GoalEnded():
                self.close()
                first, *rest = event_lines(event, self._about, self._units)
                self._console.print(Text(first, style=STYLES.get(event.end.how, "red")))
                for line in rest:
                    self._console.print(Text(line))
            case GoalStateChanged():
                if event.is_end:
                    self._others.pop(event.goal, None)
                self._draw()
                (line,) = event_lines(event, self._about, self._units)
                self._console.print(_cut(line))  # appears above what is drawn in place
            case FeedbackReceived() if event.goal:
                (self._others[event.goal],) = event_lines(event, self._about, self._units)
                self._draw()
            case FeedbackReceived():
                self._feedback = event.message
                state = self._head.plain.partition("   ")[0]
                self._head = _cut(f"{state}   {event.since_s:.1f} s", self._head.style)
                self._draw()
            case _:
                self._head = _cut(escape_control(str(event)), HEAD_STYLES.get(type(event), "red"))
                self._draw()

    def close(self) -> None:
        """Remove what is drawn in place."""
        self._live.stop()

    def _draw(self) -> None:
        self._live.start()
        self._live.update(self.picture(), refresh=True)

    def picture(self) -> RenderableType:
        """Compose what is drawn in place."""
        rows: list[RenderableType] = [self._head] if self._head else []
        if self._feedback is not None:
            rows.append(self._table.render(self._feedback, self._console.width))
        return Group(*rows, *map(_cut, self._others.values()))


class GoalObjects(GoalView):
    """Writes one JSON object a line: an event of our goal, a state or a feedback of another's."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._own = ""

    def show(self, event: GoalEvent) -> None:
        """Write the object of an event; the wait for a server is only shown to people."""
        if isinstance(event, ServerAwaited):
            sys.stderr.write(f"{event}\n")
            return
        if isinstance(event, GoalAccepted):
            self._own = event.goal
        print(as_json(self._object(event)), file=self._stream, flush=True)

    def _object(self, event: GoalEvent) -> Mapping[str, Any]:
        name, more = "accepted", dict[str, Any]()
        match event:
            case GoalStateChanged():
                return {"goal": event.goal, "state": event.state, "is_end": event.is_end}
            case FeedbackReceived() if event.goal:
                return {"goal": event.goal, "feedback": plain(event.message)}
            case FeedbackReceived():
                name = "feedback"
                more = {"since_s": round(event.since_s, 6), "feedback": plain(event.message)}
            case CancelRequested():
                name, more = "canceling", {"why": event.why}
            case CancelRefused():
                name = "refused"
            case GoalEnded(end=end):
                name = "ended"
                more = {
                    "status": str(end.how),
                    "reason": end.reason,
                    "since_s": round(event.since_s, 6),
                    "result": None if end.result is None else plain(end.result),
                }
        return {"event": name, **({"goal": self._own} if self._own else {}), **more}


def event_lines(
    event: GoalEvent, about: InterfaceDescription, units: Mapping[str, str]
) -> list[str]:
    """Write an event for people, escaped, with these units of the feedback's fields."""
    return list(map(escape_control, _event_lines(event, about, units)))


def _event_lines(
    event: GoalEvent, about: InterfaceDescription, units: Mapping[str, str]
) -> list[str]:
    match event:
        case GoalEnded(end=end) if end.result is not None:
            head = f"{end.reason} after {seconds(event.since_s)}"
            return [head, *_table(end.result, about.part("result"))]
        case GoalEnded(end=end):
            return [end.reason]
        case FeedbackReceived():
            text = on_a_line(event.message, units)
        case GoalStateChanged():
            text = event.state
        case _:
            return [str(event)]
    who = f"{event.goal[:8]} " if event.goal else ""
    return [f"{who}{seconds(event.since_s):>11}  {text}"]


def on_a_line(message: Any, units: Mapping[str, str]) -> str:
    """Write a message on one line: ``current_angle 12.5 deg, remaining_angle 77.5 deg``."""
    fields = flat(plain(message, SHOWN_ITEMS))
    return ", ".join(f"{name} {short(value)}{_unit(units, name)}" for name, value in fields)


def _table(message: Any, part: InterfacePart) -> list[str]:
    """Write a message with a line for each field, names of codes included."""
    units = part.units()
    rows = list(flat(plain(message, SHOWN_ITEMS)))
    width = max((len(name) for name, _ in rows), default=0)
    lines = []
    for name, value in rows:
        known = part.section.name_of(name, value)
        if isinstance(value, list) and len(short(value)) > LONG:
            lines += [f"  {name}", *(f"    {short(item)}" for item in value)]
            continue
        if isinstance(value, str) and "\n" in value.strip():
            first, *more = (short(line) for line in value.strip().split("\n"))
            lines += [f"  {name:{width}}  {first}", *(f"  {'':{width}}  {line}" for line in more)]
            continue
        words = f"{short(value)}{_unit(units, name)}{f'  ({known})' if known else ''}"
        lines.append(f"  {name:{width}}  {words}")
    return lines


def _unit(units: Mapping[str, str], name: str) -> str:
    unit = units.get(name, "")
    return f" {unit}" if unit else ""


def _cut(line: str, style: StyleType = "") -> Text:
    """A line that ends with an ellipsis where the terminal does."""
    return Text(line, style=style, no_wrap=True, overflow="ellipsis")
