"""Feedback as a table: names, values, units, and bars where a bound is known."""

from __future__ import annotations

from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from bt_mission.base.text import can_encode
from bt_mission.commands.graph.interface_description import InterfaceDescription
from bt_mission.commands.graph.values import SHOWN_ITEMS, flat, plain, short
from bt_mission.executive.goals.progress_bounds import ProgressBounds

BAR_WIDTH = 20
SIGNS = ("█", "░")
ASCII_SIGNS = ("#", ".")
"""For what of a bar is full, and what is empty."""

NARROW = 60
"""Columns below which there are no bars, and values are before their names."""


class FeedbackTable:
    """Draws the feedback of one goal; its goal message is None if it is not known."""

    def __init__(self, about: InterfaceDescription, goal: Any, encoding: str | None) -> None:
        self._units = about.part("feedback").units()
        self._gauges = ProgressBounds(
            {} if goal is None else dict(flat(plain(goal, SHOWN_ITEMS))),
            about.part("goal").units(),
            self._units,
        )
        self._signs = signs_for(encoding)

    def render(self, feedback: Any, width: int) -> RenderableType:
        """Return the newest feedback for a width in columns."""
        fields = dict(flat(plain(feedback, SHOWN_ITEMS)))
        bounds = self._gauges.read(fields)
        if width < NARROW:
            return Group(*(self._short_row(*field) for field in fields.items()))
        table = Table.grid(padding=(0, 2, 0, 0))
        table.add_column(no_wrap=True)
        table.add_column(no_wrap=True, justify="right")
        table.add_column(no_wrap=True)
        table.add_column(no_wrap=True)
        for name, value in fields.items():
            drawn = bar(*bounds[name], self._signs) if name in bounds else ""
            unit = self._units.get(name, "")
            table.add_row(Text(f"  {name}"), Text(short(value)), Text(unit), Text(drawn))
        return table

    def _short_row(self, name: str, value: Any) -> Text:
        unit = self._units.get(name, "")
        words = f"  {short(value)} {unit}{' ' if unit else ''}{name}"
        return Text(words, no_wrap=True, overflow="ellipsis")


def signs_for(encoding: str | None) -> tuple[str, str]:
    """The signs for full and empty that a terminal of this encoding can show."""
    return SIGNS if can_encode("".join(SIGNS), encoding) else ASCII_SIGNS


def bar(value: float, bound: float, signs: tuple[str, str]) -> str:
    """A bar towards a bound, and the bound."""
    full = round(BAR_WIDTH * min(abs(value) / bound, 1.0))
    return f"{signs[0] * full}{signs[1] * (BAR_WIDTH - full)} of {short(bound)}"
