"""Screens over the view: the help, and a list of executives to choose from."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import ClassVar, TypeVar

from textual import events
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.screen import ModalScreen

from bt_mission.executive.events.source import ListedExecutive
from bt_mission.views.terminal.marks import Marks, Span
from bt_mission.views.tui.keys import Key
from bt_mission.views.tui.pane import Pane

Result = TypeVar("Result")


class Dialog(ModalScreen[Result]):
    """A pane over the whole view."""

    DEFAULT_CSS = """
    ModalScreen { background: ansi_default; } ModalScreen > Pane { height: 100%; }
    """

    def __init__(self, marks: Marks) -> None:
        super().__init__()
        self._marks = marks
        self._pane = Pane(marks)

    def compose(self) -> ComposeResult:
        """One pane."""
        yield self._pane


def help_rows(keys: Sequence[Key], leave: str) -> list[list[Span]]:
    """A row for each key."""
    rows: list[list[Span]] = []
    for key in keys:
        if key.help:
            words = leave if key.action == "leave" else key.help
            rows.append([(f"{key.shown:>11}", "key"), (f"  {words}", "")])
    return rows


class Help(Dialog[None]):
    """All keys; any of them closes it, except those that scroll.

    Args:
        keys: The keys of the view.
        leave: The action of the key for leaving.
    """

    def __init__(self, marks: Marks, keys: Sequence[Key], leave: str) -> None:
        super().__init__(marks)
        self._rows = help_rows(keys, leave)
        self._top = 0

    def on_resize(self) -> None:
        """Show what fits."""
        self.call_after_refresh(self._show)

    def on_key(self, event: events.Key) -> None:
        """Scroll, or close."""
        event.stop()
        if event.key in ("down", "j", "pagedown", "up", "k", "pageup"):
            step = 1 if event.key in ("down", "j", "pagedown") else -1
            most = max(len(self._rows) - self._pane.room, 0)
            self._top = min(max(self._top + step, 0), most)
            self._show()
        else:
            self.dismiss()

    def _show(self) -> None:
        rows = self._rows[self._top :]
        more = "down scrolls" if len(self._rows) > self._pane.room else "any key closes"
        self._pane.show(rows, "keys", more)


class Chooser(Dialog[str | None]):
    """The executives of the graph; returns the name of the chosen one.

    Args:
        find: Searches for them.
        where: The place that is searched.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("up,k", "move(-1)"),
        Binding("down,j", "move(1)"),
        Binding("enter,space", "choose"),
        Binding("escape,q,c,ctrl+c", "cancel"),
    ]

    def __init__(
        self, marks: Marks, find: Callable[[], tuple[ListedExecutive, ...]], where: str
    ) -> None:
        super().__init__(marks)
        self._find = find
        self._where = where
        self._executives: tuple[ListedExecutive, ...] = ()
        self._cursor = 0

    def on_mount(self) -> None:
        """Search for executives as long as the list is shown."""
        self.set_interval(0.25, self.look)
        self.call_after_refresh(self.look)

    def look(self) -> None:
        """Show those that are there now."""
        self._executives = self._find()
        self._cursor = min(self._cursor, max(len(self._executives) - 1, 0))
        rows: list[list[Span]] = [
            [
                (f"{self._marks.cursor if number == self._cursor else ' '} ", "key"),
                (executive.name, "chosen" if number == self._cursor else "title"),
                (f"  {executive.problem}" if executive.problem else "", "notice"),
            ]
            for number, executive in enumerate(self._executives)
        ]
        if not rows:
            rows = [[(f"no executive yet ({self._where}); looking", "")]]
        rows += [[], [("Enter", "key"), (" watches it, ", ""), ("Esc", "key"), (" goes back", "")]]
        self._pane.show(rows, "executives")

    def action_move(self, rows: int) -> None:
        """Select another one."""
        self._cursor = min(max(self._cursor + rows, 0), max(len(self._executives) - 1, 0))
        self.look()

    def action_choose(self) -> None:
        """Choose the selected one, unless it cannot be watched."""
        if self._executives and not self._executives[self._cursor].is_foreign:
            self.dismiss(self._executives[self._cursor].name)

    def action_cancel(self) -> None:
        """Go back without a choice."""
        self.dismiss(None)
