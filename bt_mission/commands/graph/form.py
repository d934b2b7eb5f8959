"""A form for one goal: its fields, then its feedback, then its end."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from rich.console import RenderableType
from rich.text import Text
from textual import events, on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.widgets import Checkbox, Footer, Input, Label, Static

from bt_mission.base.errors import BtMissionError
from bt_mission.base.text import escape_control
from bt_mission.commands.graph import goal_events
from bt_mission.commands.graph.feedback_table import ASCII_SIGNS, FeedbackTable, signs_for
from bt_mission.commands.graph.form_fields import FormField, lines_of, texts
from bt_mission.commands.graph.goal_request import GoalRequest
from bt_mission.commands.graph.goal_views import event_lines
from bt_mission.language.message_types import nested
from bt_mission.views.terminal.screen import EscapingApp

if TYPE_CHECKING:
    from bt_mission.commands.graph.goal_request import GoalSender
    from bt_mission.ros.graph_session import GraphSession

PERIOD_S = 0.05
"""The interval at which received messages are handled, s."""


class FormLine(Vertical):
    """A field with its name, its type, what is to be known of it, and what is wrong with it."""

    def __init__(self, line: FormField, text: str) -> None:
        super().__init__()
        self.line = line
        self._text = text

    def compose(self) -> ComposeResult:
        """Name, input and type in one row; the note below."""
        with Horizontal(classes="row"):
            yield Label(self.line.name, classes="name", markup=False)
            if self.line.is_truth:
                ticked = (self._text or self.line.placeholder) == "true"
                yield Checkbox(value=ticked, compact=True)
            else:
                yield Input(self._text, placeholder=self.line.placeholder, compact=True)
            yield Label(self.line.kind, classes="kind", markup=False)
        yield Static(escape_control(self.line.note), classes="note", markup=False)

    def read(self) -> tuple[Any, str] | None:
        """Return value and error; None leaves the default."""
        if self.line.is_truth:
            return self.query_one(Checkbox).value, ""
        text = self.query_one(Input).value
        return self.line.read(text) if text.strip() else None

    @on(events.Mount)
    @on(Input.Changed)
    def check(self) -> bool:
        """Show the error, if any. Return whether the value is valid."""
        entry = self.read()
        problem = entry[1] if entry else ""
        self.set_class(bool(problem), "wrong")
        self.query_one(".note", Static).update(escape_control(problem or self.line.note))
        return not problem


class GoalFormApp(EscapingApp[goal_events.GoalResult | None]):
    """Fills in a goal, sends it, shows its feedback; gives the end of the last goal.

    Its ``last_words`` are the end and the result of that goal, for people.

    Args:
        fields: Of the goal, to begin with.
        encoding: Of the terminal; what it cannot show is drawn in ASCII.
        period_s: How often to serve what has come, s; None leaves it to the caller.
    """

    ENABLE_COMMAND_PALETTE = False
    CSS = """
    #head { height: 1; padding: 0 1; background: $panel; text-style: bold; }
    #about { padding: 0 1; color: $text-muted; }
    FormLine { height: auto; padding: 0 1; margin: 0 0 1 0; }
    .row { height: 1; }
    .name { width: 28%; min-width: 6; text-style: bold; }
    FormLine Input { width: 1fr; background: $surface; }
    FormLine Checkbox { width: 1fr; background: transparent; border: none; }
    .kind { width: auto; max-width: 35%; padding: 0 0 0 1; color: $text-muted; }
    .note { padding: 0 0 0 2; color: $text-muted; }
    .wrong .note { color: $text-error; text-style: bold; }
    #progress { height: auto; max-height: 50%; border-top: solid $primary; padding: 0 1; }
    .ascii #progress { border-top: ascii $primary; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+s", "send", "Send", priority=True),
        Binding("escape", "cancel", "Cancel the goal", priority=True),
        Binding("ctrl+q", "leave", "Leave", priority=True),
        Binding("ctrl+c", "leave", "Leave", show=False, priority=True),
    ]

    def __init__(
        self,
        session: GraphSession,
        sender: GoalSender,
        fields: Mapping[str, Any],
        *,
        encoding: str | None = "utf-8",
        period_s: float | None = PERIOD_S,
    ) -> None:
        super().__init__()
        self._session = session
        self._sender = sender
        self._about = sender.about
        self._lines = lines_of(self._about.part("goal"))
        self._texts = texts(self._lines, fields)
        self._encoding = encoding
        self._period_s = period_s
        self._goal: GoalRequest | None = None
        self._table: FeedbackTable | None = None
        self._end: goal_events.GoalResult | None = None
        self._state = ""
        self._is_leaving = False
        self._interrupts = 0
        self.last_words = ["nothing was sent"]

    def compose(self) -> ComposeResult:
        """Head, fields, progress, keys."""
        yield Static(f"{self._sender.action}  {self._about.type}", id="head", markup=False)
        with VerticalScroll(id="fields", can_focus=False):
            if self._about.text:
                yield Static(escape_control(self._about.text), id="about", markup=False)
            for line in self._lines:
                yield FormLine(line, self._texts.get(line.name, ""))
            if not self._lines:
                yield Static("the goal has no fields", id="about_none", markup=False)
        with VerticalScroll(id="progress", can_focus=False):
            yield Static(
                "fill in the fields, then press Ctrl-S; an empty field keeps its default",
                id="state",
            )
            yield Static("", id="feedback")
        yield Footer()

    def on_mount(self) -> None:
        """Begin to serve the graph."""
        self.screen.set_class(signs_for(self._encoding) == ASCII_SIGNS, "ascii")
        if self._period_s is not None:
            self.set_interval(self._period_s, self.serve)

    def serve(self) -> None:
        """Handle received messages, and poll the goal."""
        self._session.glance()
        if self._session.interrupts.count > self._interrupts:
            self._interrupts = self._session.interrupts.count
            self.action_leave()
        if self._goal is not None and self._goal.poll(self._session.now_ns) is not None:
            self._goal = None
            if self._is_leaving:
                self.exit(self._end)

    # ---- keys --------------------------------------------------------------------------------

    @on(Input.Submitted)
    def go_on(self, event: Input.Submitted) -> None:
        """Enter goes to the next field, and sends from the last."""
        inputs = list(self.query(Input))
        if event.input is inputs[-1]:
            self.action_send()
        else:
            inputs[inputs.index(event.input) + 1].focus()

    def action_send(self) -> None:
        """Send the goal, unless a field is wrong or a goal is under way."""
        rows = list(self.query(FormLine))
        if self._goal is not None:
            self._say("a goal is running; Escape cancels it")
            return
        wrong = [row for row in rows if not row.check()]
        if wrong:
            wrong[0].query_one(Input).focus()  # a truth is never wrong
            self._say(f"not sent: {', '.join(row.line.name for row in wrong)} invalid")
            return
        entries = {row.line.name: row.read() for row in rows}
        values = {name: entry[0] for name, entry in entries.items() if entry is not None}
        try:
            request = self._sender.prepare(nested(values))
        except BtMissionError as error:
            self._say(f"not sent: {error}")
            return
        self._table = FeedbackTable(self._about, request, self._encoding)
        self._show("")
        self._say("sending")
        self._goal = self._sender.open(request, self.show)

    def action_cancel(self) -> None:
        """Cancel the goal that is under way."""
        if self._goal is None:
            self._say("no goal is running; Ctrl-Q exits")
        else:
            self._goal.cancel("by you", self._session.now_ns)

    def action_leave(self) -> None:
        """Leave; a goal under way is cancelled first. The second time leaves at once."""
        if self._goal is None:
            self.exit(self._end)
            return
        if not self._is_leaving:
            self._is_leaving = True
            self._goal.cancel("you exited", self._session.now_ns)
        else:
            self._goal.leave("you exited at once", self._session.now_ns)
            self.exit(self._end)

    # ---- what becomes of the goal --------------------------------------------------------------

    def show(self, event: goal_events.GoalEvent) -> None:
        """Show what has happened to the goal."""
        match event:
            case goal_events.FeedbackReceived():
                self._say(f"{self._state}   {event.since_s:.1f} s")
                assert self._table is not None
                self._show(self._table.render(event.message, self.size.width - 2))
            case goal_events.GoalEnded():
                self._end = event.end
                self.last_words = event_lines(event, self._about, {})
                first, *rest = self.last_words
                self._say(first)
                if rest:
                    self._show(Text("\n".join(rest)))
            case goal_events.CancelRefused():
                self._say(str(event))
            case _:
                self._state = str(event)
                self._say(self._state)

    def _say(self, text: str) -> None:
        self.query_one("#state", Static).update(Text(escape_control(text), style="bold"))

    def _show(self, what: RenderableType) -> None:
        self.query_one("#feedback", Static).update(what)
