"""The life of a goal sent by hand, drawn in place on a terminal."""

from __future__ import annotations

from typing import Any

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.text import Text

from bt_mission.goals.goal import Goal
from bt_mission.graph_tools.feedback_table import FeedbackTable
from bt_mission.graph_tools.goal_lines import end_lines
from bt_mission.graph_tools.goal_request import GoalOutcome, GoalResult
from bt_mission.graph_tools.interface_description import InterfaceDescription

STYLES = {GoalOutcome.SUCCEEDED: "green", GoalOutcome.CANCELED: "yellow"}


class GoalPicture:
    """Feedback as a table that is drawn anew; then how the goal ended, to stay.

    :param console: a terminal.
    :param about: the action's type.
    :param goal: the goal message.
    """

    def __init__(self, console: Console, about: InterfaceDescription, goal: Any) -> None:
        self._console = console
        self._about = about
        self._table = FeedbackTable(about, goal, console.encoding)
        self._head = Text("")
        self._feedback: Any = None
        self._live = Live(console=console, auto_refresh=False, transient=True)
        self._is_open = False

    def close(self) -> None:
        """Take the picture away; what was said stays."""
        if self._is_open:
            self._is_open = False
            self._live.stop()

    def waiting(self, action: str) -> None:
        """There is no server yet."""
        self._draw(f"waiting for a server of {action}", "dim")

    def accepted(self, goal: Goal) -> None:
        """The server accepted it."""
        self._draw(f"goal {goal.short_id} accepted", "bold")

    def feedback(self, message: Any, since_s: float) -> None:
        """Feedback came."""
        self._feedback = message
        state = self._head.plain.partition("   ")[0]
        self._draw(f"{state}   {since_s:.1f} s", self._head.style or "")

    def canceling(self, why: str) -> None:
        """Its cancel has been asked for."""
        self._draw(f"canceling: {why}", "yellow")

    def refused(self) -> None:
        """The server refused to cancel."""
        self._draw("the server refused to cancel; asking again each second", "red")

    def ended(self, end: GoalResult, since_s: float) -> None:
        """It has ended."""
        self.close()
        first, *rest = end_lines(end, self._about, since_s)
        self._console.print(Text(first, style=STYLES.get(end.how, "red")))
        for line in rest:
            self._console.print(Text(line))

    def _draw(self, head: str, style: Any) -> None:
        if not self._is_open:
            self._is_open = True
            self._live.start()
        self._head = Text(head, style=style, no_wrap=True, overflow="ellipsis")
        self._live.update(self._render(), refresh=True)

    def _render(self) -> RenderableType:
        if self._feedback is None:
            return self._head
        return Group(self._head, self._table.render(self._feedback, self._console.width))
