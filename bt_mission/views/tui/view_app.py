"""The common part of all full-screen views: the tree, panels, a search, a line to type."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar

from textual import events
from textual.widgets import Input

from bt_mission.base.wall_clock import Stopwatch
from bt_mission.views.terminal.marks import Marks, Span
from bt_mission.views.terminal.screen import EscapingApp
from bt_mission.views.tui.dialogs import Help
from bt_mission.views.tui.keys import Key
from bt_mission.views.tui.layout import PANELS, REQUIREMENTS, MainScreen
from bt_mission.views.tui.watch_model import WatchModel

FRAME_S = 0.1
"""Wall time between two looks at what is new."""

NOTICE_S = 5.0
"""The time for which a notice replaces the keys."""


@dataclass(frozen=True)
class Prompt:
    """A line that the user types.

    Args:
        hint: Shown while nothing is typed.
        take: Called with the text at the end; ``follow`` with the text at each change.
        give_up: Called when the user cancels.
    """

    hint: str
    take: Callable[[str], None]
    follow: Callable[[str], None] = lambda _: None
    give_up: Callable[[], None] = lambda: None


class ViewApp(EscapingApp[None]):
    """Shows a mission. Subclasses define its content, and further keys.

    Args:
        marks: The terminal's signs.
    """

    ENABLE_COMMAND_PALETTE = False
    keys: ClassVar[Sequence[Key]]
    """All keys of the view."""
    leaving: ClassVar[str]
    """The action of the key for leaving, for the help."""
    has_time: ClassVar[bool] = False
    """Whether there is a line of time."""

    def __init__(self, marks: Marks) -> None:
        super().__init__(ansi_color=True)
        self.outlook = WatchModel()
        self._marks = marks
        self._wall = Stopwatch()
        self._main = MainScreen(marks, has_time=self.has_time)
        self._notice = ""
        self._notice_until_s = 0.0
        self._prompt: Prompt | None = None

    def on_mount(self) -> None:
        """Begin."""
        self.push_screen(self._main)
        self.set_interval(FRAME_S, self.look)
        self.call_after_refresh(self.look)

    def on_resize(self) -> None:
        """Put the panes in their new places."""
        self.call_after_refresh(self._rearrange)

    @abstractmethod
    def look(self) -> None:
        """Take what is new, and show it."""

    @abstractmethod
    def draw(self) -> None:
        """Show what is known."""

    @abstractmethod
    def keys_now(self) -> list[str]:
        """The keys that make sense now: each a key, a blank, and what it does."""

    def show_notice(self, text: str) -> None:
        """Show a line in the place of the keys, for a while."""
        self._notice = text
        self._notice_until_s = self._wall.elapsed_s + NOTICE_S
        self.draw()

    def foot(self) -> list[Span]:
        """The last line: a notice, else keys."""
        if self._notice and self._wall.elapsed_s < self._notice_until_s:
            return [(self._notice, "notice")]
        spans: list[Span] = []
        for key in self.keys_now():
            name, _, what = key.partition(" ")
            spans += [(name, "key"), (f" {what}  ", "words")]
        return spans

    @property
    def next_panel(self) -> str:
        """The name of the panel that is shown next."""
        return self._panel_beside(1)

    def _panel_beside(self, step: int) -> str:
        shown = self._main.panel
        has_requirements = bool(self.outlook.mission.requirements)
        panels = [
            panel for panel in PANELS if panel != REQUIREMENTS or has_requirements or panel == shown
        ]
        return panels[(panels.index(shown) + step) % len(panels)]

    def _rearrange(self) -> None:
        self._main.place_panes()
        self.call_after_refresh(self.draw)

    # ---- the tree ------------------------------------------------------------------------

    def action_move(self, rows: int) -> None:
        """Select another node, or scroll the enlarged panel."""
        if self._main.is_large:
            up = rows if self._main.panel != "log" else -rows
            self._main.scroll = max(self._main.scroll + up, 0)
        else:
            self.outlook.move(rows)
        self.draw()

    def action_page(self, pages: int) -> None:
        """As :meth:`action_move`, by the number of rows in view."""
        name = self._main.panel if self._main.is_large else "tree"
        self.action_move(pages * max(self._main.panes[name].room - 1, 1))

    def action_tree(self, change: str) -> None:
        """Fold, unfold or follow: the method of :class:`WatchModel` of this name."""
        getattr(self.outlook, change)()
        self.draw()

    def on_click(self, event: events.Click) -> None:
        """Select the node that is clicked on; fold or unfold it with a second click."""
        if event.widget is self._main.panes["tree"] and event.y > 0:
            self.outlook.move(self.outlook.top + event.y - 1 - self.outlook.cursor_row)
            if event.chain > 1:
                self.outlook.toggle()
            self.draw()

    def on_mouse_scroll_down(self) -> None:
        """Scroll down."""
        self.action_move(1)

    def on_mouse_scroll_up(self) -> None:
        """Scroll up."""
        self.action_move(-1)

    # ---- a line to be typed into ---------------------------------------------------------

    def ask(self, prompt: Prompt) -> None:
        """Have the user type a line in the place of the keys."""
        self._prompt = prompt
        search = self._main.search
        search.value = ""
        search.placeholder = prompt.hint
        search.display = True
        self._main.panes["foot"].display = False
        # At once: the next input is not a key.
        self._main.set_focus(search, scroll_visible=False)

    def on_input_changed(self, event: Input.Changed) -> None:
        """Follow what is typed."""
        if self._prompt is not None and event.value:
            self._prompt.follow(event.value)

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Take what was typed."""
        if (prompt := self._close_prompt()) is not None and event.value:
            prompt.take(event.value)
        self.draw()

    def key_escape(self) -> None:
        """Go back."""
        if (prompt := self._close_prompt()) is not None:
            prompt.give_up()
            self.draw()

    def _close_prompt(self) -> Prompt | None:
        prompt, self._prompt = self._prompt, None
        self._main.search.display = False
        self._main.panes["foot"].display = True
        self._main.set_focus(None)
        return prompt

    def action_search(self) -> None:
        """Ask for a text, and select the first node that matches so far."""
        before = self.outlook.cursor

        def follow(text: str) -> None:
            self.outlook.search(text, before - 1)
            self.draw()

        def take(text: str) -> None:
            if not self.outlook.search(text, before - 1):
                self.show_notice(f"'{text}' is not in the tree")

        def give_up() -> None:
            self.outlook.cursor = before

        self.ask(Prompt("search; Enter confirms, Esc cancels", take, follow, give_up))

    def action_again(self, step: int) -> None:
        """The next node with the text of the last search."""
        if not self.outlook.search(self.outlook.sought, self.outlook.cursor, step=step):
            self.show_notice("no search yet; press /")
        self.draw()

    # ---- panels and screens --------------------------------------------------------------

    def action_next_panel(self, step: int) -> None:
        """Show another panel."""
        main = self._main
        main.panel = self._panel_beside(step)
        main.scroll = 0
        self._rearrange()

    def action_focus_next(self) -> None:
        """Override Textual's action of Tab."""
        self.action_next_panel(1)

    def action_focus_previous(self) -> None:
        """Override Textual's action of Shift+Tab."""
        self.action_next_panel(-1)

    def action_enlarge(self) -> None:
        """Enlarge the panel to the whole view, or restore it."""
        self._main.is_large = not self._main.is_large
        self._main.scroll = 0
        self._rearrange()

    def action_help(self) -> None:
        """Show the keys."""
        self.push_screen(Help(self._marks, self.keys, self.leaving))

    def action_leave(self) -> None:
        """Leave."""
        self.exit()
