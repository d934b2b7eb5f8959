"""The full-screen view: keys, time, and who is watched."""

from __future__ import annotations

from typing import ClassVar

from textual import events
from textual.app import App
from textual.binding import Binding, BindingType
from textual.widgets import Input

from bt_mission.pacing import Stopwatch
from bt_mission.terminal.arrangement import PANELS
from bt_mission.terminal.marks import Marks
from bt_mission.terminal.screen.dialogs import Chooser, Help
from bt_mission.terminal.screen.keys import KEYS
from bt_mission.terminal.screen.layout import MainScreen
from bt_mission.terminal.words import Span
from bt_mission.watching.attachment import Attachment
from bt_mission.watching.outlook import Outlook
from bt_mission.watching.source import Command, Found, Graph, Source, Verb
from bt_mission.watching.told import FINAL

FRAME_S = 0.1
"""Wall time between two looks at what has come."""

CHECK_S = 1.0
"""Wall time between two looks at who is there, once somebody is watched."""

NOTICE_S = 5.0
"""How long a notice stands in the place of the keys."""


class WatchApp(App[None]):
    """Shows an executive of a graph, and passes on what the user wants of it.

    :param graph: where executives are found.
    :param marks: the terminal's signs.
    :param name: of the executive to watch; None takes the only one, or asks.
    :param wait_s: wall time after which it leaves when nobody was there to watch; None keeps
        looking. The return code is then 1.
    """

    ENABLE_COMMAND_PALETTE = False
    leaving = "leave; the mission runs on"
    """What the key for that does, for the help."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding(key.keys, key.action, show=False) for key in KEYS
    ]

    def __init__(
        self, graph: Graph, marks: Marks, name: str | None = None, *, wait_s: float | None = None
    ) -> None:
        super().__init__(ansi_color=True)
        self.graph = graph
        self.outlook = Outlook()
        self.attachment = Attachment(graph, name)
        self._marks = marks
        self._wait_s = wait_s
        self._wall = Stopwatch()
        self._since_check = Stopwatch()
        self._main = MainScreen(marks)
        self._notice = ""
        self._notice_until_s = 0.0
        self._may_stop = False
        self._before_search = 0

    def on_mount(self) -> None:
        """Begin."""
        self.push_screen(self._main)
        self.set_interval(FRAME_S, self.look)
        self.call_after_refresh(self.look)

    def on_resize(self) -> None:
        """Put the panes in their new places."""
        self.call_after_refresh(self._rearrange)

    # ---- what comes ----------------------------------------------------------------------

    def look(self) -> None:
        """Take what has come, and show it."""
        self.graph.serve()
        self._look_round()
        if self.source is not None:
            needs = self.outlook.mission.needs_statuses
            heard = self.source.take(needs_statuses=needs)
            self.outlook.take(heard, self._wall.elapsed_s)
            for answer in heard.answers:
                self.tell(answer.text)
        self.draw()

    def draw(self) -> None:
        """Show what is known."""
        is_there = self.source is not None and self.source.is_there
        self._main.show(self.outlook, self._foot(), is_there=is_there)

    def attach(self, name: str) -> None:
        """Watch this executive from now on."""
        self.outlook = Outlook()
        self.attachment.attach(name)

    @property
    def source(self) -> Source | None:
        """Who is watched."""
        return self.attachment.source

    def _look_round(self) -> None:
        """Look at who is there: always while nobody is watched, and now and then after that."""
        if self.source is not None and self._since_check.elapsed_s < CHECK_S:
            return
        self._since_check = Stopwatch()
        finding = self.attachment.look()
        if finding.is_new:
            self.outlook = Outlook()
        elif finding.is_choice:
            self.action_choose()
        elif finding.text and self._wait_s is not None and self._wall.elapsed_s > self._wait_s:
            self.exit(return_code=1)
        if finding.text:
            self.tell(finding.text)

    def tell(self, text: str) -> None:
        """Show a line in the place of the keys, for a while."""
        self._notice = text
        self._notice_until_s = self._wall.elapsed_s + NOTICE_S
        self.draw()

    def _foot(self) -> list[Span]:
        if self._notice and self._wall.elapsed_s < self._notice_until_s:
            return [(self._notice, "notice")]
        status = self.outlook.mission.status
        if status == "paused":
            keys = ["r resume", "s step", "x stop"]
        elif status in FINAL or not status:
            keys = []
        else:
            keys = ["p pause", "x stop"]
        keys += ["b break", "/ search", "f follow", f"Tab {self._next_panel}", "? help", "q leave"]
        spans: list[Span] = []
        for key in keys:
            name, _, what = key.partition(" ")
            spans += [(name, "key"), (f" {what}  ", "words")]
        return spans

    @property
    def _next_panel(self) -> str:
        return PANELS[(PANELS.index(self._main.panel) + 1) % len(PANELS)]

    def _rearrange(self) -> None:
        self._main.place_panes()
        self.call_after_refresh(self.draw)

    # ---- wishes --------------------------------------------------------------------------

    def send_command(self, command: Command) -> None:
        """Pass a wish on to the executive."""
        if self.source is not None:
            self.source.send(command)

    def action_pause(self) -> None:
        """Pause."""
        self.send_command(Command(Verb.PAUSE))

    def action_pause_keeping(self) -> None:
        """Pause, while goals run on."""
        self.send_command(Command(Verb.PAUSE_KEEPING_GOALS))

    def action_resume(self) -> None:
        """Go on."""
        self.send_command(Command(Verb.RESUME))

    def action_step(self) -> None:
        """One tick."""
        self.send_command(Command(Verb.STEP))

    def action_stop(self) -> None:
        """Stop, when asked twice in a row."""
        if self._may_stop:
            self._may_stop = False
            self.send_command(Command(Verb.STOP))
        else:
            self._may_stop = True
            self.tell("x again stops the mission; any other key does not")

    def action_breakpoint(self) -> None:
        """Set or remove the breakpoint at the selected node."""
        if (command := self.outlook.breakpoint()) is not None:
            self.send_command(command)

    def on_event_key(self, key: str) -> None:
        """Forget the wish to stop when another key is pressed."""
        if key != "x" and self._may_stop:
            self._may_stop = False
            self._notice = ""

    async def on_event(self, event: events.Event) -> None:
        """See every key before it is acted upon."""
        if isinstance(event, events.Key):
            self.on_event_key(event.key)
        await super().on_event(event)

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
        """As :meth:`action_move`, by what is in view."""
        name = self._main.panel if self._main.is_large else "tree"
        self.action_move(pages * max(self._main.panes[name].room - 1, 1))

    def action_fold(self) -> None:
        """Fold."""
        self.outlook.fold()
        self.draw()

    def action_unfold(self) -> None:
        """Unfold."""
        self.outlook.unfold()
        self.draw()

    def action_fold_or_unfold(self) -> None:
        """Fold or unfold."""
        self.outlook.toggle()
        self.draw()

    def action_fold_all(self) -> None:
        """Fold or unfold everything."""
        self.outlook.fold_all()
        self.draw()

    def action_follow(self) -> None:
        """Go with what runs, or no longer."""
        self.outlook.follow()
        self.look()

    def on_click(self, event: events.Click) -> None:
        """Select the node that is clicked on; fold or unfold it with a second click."""
        if event.widget is self._main.panes["tree"] and event.y > 0:
            self.outlook.select_row(event.y - 1)
            if event.chain > 1:
                self.outlook.toggle()
            self.draw()

    def on_mouse_scroll_down(self) -> None:
        """As the key."""
        self.action_move(1)

    def on_mouse_scroll_up(self) -> None:
        """As the key."""
        self.action_move(-1)

    # ---- search --------------------------------------------------------------------------

    def action_search(self) -> None:
        """Ask for a text."""
        self._before_search = self.outlook.cursor
        self._main.search.value = ""
        self._main.search.placeholder = "search; Enter takes it, Esc goes back"
        self._main.search.display = True
        self._main.panes["foot"].display = False
        # At once: what is typed next is for the search, not for the mission.
        self._main.set_focus(self._main.search, scroll_visible=False)

    def on_input_changed(self, event: Input.Changed) -> None:
        """Select the first node that matches so far."""
        if event.input.display and event.value:
            self.outlook.search(event.value, self._before_search - 1)
            self.draw()

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Stay with what was found."""
        self._close_search()
        if event.value and not self.outlook.search(event.value, self._before_search - 1):
            self.tell(f"'{event.value}' is nowhere in the tree")
        self.draw()

    def action_again(self, step: int) -> None:
        """The next node with the text of the last search."""
        if not self.outlook.search(self.outlook.sought, self.outlook.cursor, step=step):
            self.tell("nothing was searched for yet: / does")
        self.draw()

    def key_escape(self) -> None:
        """Leave the search as if it had not been."""
        if self._main.search.display:
            self._close_search()
            self.outlook.cursor = self._before_search
            self.draw()

    def _close_search(self) -> None:
        self._main.search.display = False
        self._main.panes["foot"].display = True
        self._main.set_focus(None)

    # ---- panels and screens --------------------------------------------------------------

    def action_next_panel(self, step: int) -> None:
        """Show another panel."""
        main = self._main
        main.panel = PANELS[(PANELS.index(main.panel) + step) % len(PANELS)]
        main.scroll = 0
        self._rearrange()

    def action_focus_next(self) -> None:
        """What Textual's own screens do on Tab."""
        self.action_next_panel(1)

    def action_focus_previous(self) -> None:
        """What they do on Shift+Tab."""
        self.action_next_panel(-1)

    def action_enlarge(self) -> None:
        """Give the panel the place of all others, or take it back."""
        self._main.is_large = not self._main.is_large
        self._main.scroll = 0
        self._rearrange()

    def action_help(self) -> None:
        """Show the keys."""
        self.push_screen(Help(self._marks, self.leaving))

    def action_choose(self) -> None:
        """Choose among the executives of the graph."""
        if isinstance(self.screen, Chooser):
            return

        def chosen(name: str | None) -> None:
            if name is not None:
                self.attach(name)

        self.push_screen(Chooser(self._marks, self._find, self.graph.where), chosen)

    def _find(self) -> tuple[Found, ...]:
        return self.graph.find()

    def action_leave(self) -> None:
        """Leave; the mission runs on."""
        self.exit()
