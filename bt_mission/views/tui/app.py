"""The full-screen view of executives: the attachment, and the user's requests."""

from __future__ import annotations

from typing import ClassVar

from textual import events
from textual.binding import Binding, BindingType

from bt_mission.base.wall_clock import Stopwatch
from bt_mission.executive.events.source import (
    Attachment,
    ControlRequest,
    ExecutiveSource,
    Graph,
    Verb,
)
from bt_mission.executive.events.watched_mission import possible_verbs
from bt_mission.views.terminal.marks import Marks, Span
from bt_mission.views.tui.dialogs import Chooser
from bt_mission.views.tui.keys import KEYS
from bt_mission.views.tui.view_app import ViewApp
from bt_mission.views.tui.watch_model import WatchModel

CHECK_S = 1.0
"""Wall time between two searches for executives, once one is attached."""

KEY_WORDS = {
    Verb.PAUSE: "p pause",
    Verb.RESUME: "r resume",
    Verb.STEP: "s step",
    Verb.STOP: "x stop",
    Verb.BREAK: "b break",
}
"""The keys that are named in the last line."""


class WatchApp(ViewApp):
    """Shows an executive of a graph, and sends it the user's requests.

    Args:
        graph: The executives.
        marks: The terminal's signs.
        name: The executive to watch; None takes the only one, or asks.
        wait_s: Wall time after which it leaves without an executive; None keeps looking. The return
            code is then 1.
    """

    keys = KEYS
    leaving = "exit; the mission continues"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding(key.keys, key.action, show=False) for key in KEYS
    ]

    def __init__(
        self, graph: Graph, marks: Marks, name: str | None = None, *, wait_s: float | None = None
    ) -> None:
        super().__init__(marks)
        self.graph = graph
        self.attachment = Attachment(graph, name)
        self._wait_s = wait_s
        self._since_check = Stopwatch()
        self._may_stop = False

    # ---- received messages ------------------------------------------------------------------

    def look(self) -> None:
        """Show what was received."""
        self.graph.serve()
        self._look_round()
        if self.source is not None:
            needs = self.outlook.needs_statuses
            received = self.source.take(needs_statuses=needs)
            self.outlook.take(received, self._wall.elapsed_s)
            for answer in received.answers:
                self.show_notice(self.outlook.with_names(answer.text))
        self.draw()

    def draw(self) -> None:
        """Show what is known."""
        before: list[Span] = []
        if self.source is None or not self.source.is_there:
            known = self.outlook.mission.state is not None
            before = [
                (" disconnected; reconnecting " if known else " searching ", "paused"),
                (" ", ""),
            ]
        self._main.show(self.outlook, self.foot(), before)

    def attach(self, name: str) -> None:
        """Watch this executive from now on."""
        self.outlook = WatchModel()
        self.attachment.attach(name)

    @property
    def source(self) -> ExecutiveSource | None:
        """The source of the attached executive."""
        return self.attachment.source

    def _look_round(self) -> None:
        """Search for executives: always without an attachment, and every few seconds with one."""
        if self.source is not None and self._since_check.elapsed_s < CHECK_S:
            return
        self._since_check = Stopwatch()
        self.outlook.check_file()
        finding = self.attachment.look()
        if finding.is_new:
            self.outlook = WatchModel()
        elif finding.is_choice:
            self.action_choose()
        elif finding.text and self._wait_s is not None and self._wall.elapsed_s > self._wait_s:
            self.exit(return_code=1)
        self.outlook.hint = finding.text
        if finding.text and not finding.is_nobody:
            self.show_notice(finding.text)

    def keys_now(self) -> list[str]:
        """Those that its state allows."""
        if self.source is None:
            return ["c choose", "? help", "q leave"]
        others = ["/ search", "f follow", f"Tab {self.next_panel}", "? help", "q leave"]
        if not self.source.is_there:
            return others
        verbs = possible_verbs(self.outlook.mission.status)
        return [*(KEY_WORDS[verb] for verb in verbs if verb in KEY_WORDS), *others]

    # ---- wishes --------------------------------------------------------------------------

    def send_command(self, command: ControlRequest) -> None:
        """Pass a wish on to the executive."""
        if self.source is not None:
            self.source.send(command)

    def action_send(self, verb: str) -> None:
        """Pass on the wish of this name."""
        self.send_command(ControlRequest(Verb[verb]))

    def action_stop(self) -> None:
        """Stop, after a second request."""
        if self._may_stop:
            self._may_stop = False
            self.send_command(ControlRequest(Verb.STOP))
        else:
            self._may_stop = True
            self.show_notice("x again stops the mission; any other key does not")

    def action_breakpoint(self) -> None:
        """Set or remove the breakpoint at the selected node."""
        if (command := self.outlook.breakpoint()) is not None:
            self.send_command(command)

    async def on_event(self, event: events.Event) -> None:
        """Forget the wish to stop when another key is pressed."""
        if isinstance(event, events.Key) and event.key != "x" and self._may_stop:
            self._may_stop = False
            self._notice = ""
        await super().on_event(event)

    def action_choose(self) -> None:
        """Choose among the executives of the graph."""
        if isinstance(self.screen, Chooser):
            return

        def chosen(name: str | None) -> None:
            if name is not None:
                self.attach(name)

        self.push_screen(Chooser(self._marks, self.graph.find, self.graph.where), chosen)
