"""The full-screen view of executives: who is watched, and what the user wants of them."""

from __future__ import annotations

from typing import ClassVar

from textual import events
from textual.binding import Binding, BindingType

from bt_mission.core.interrupts import InterruptSignals
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.events.events import FINAL
from bt_mission.events.source import (
    Attachment,
    ControlRequest,
    ExecutiveSource,
    Graph,
    Verb,
)
from bt_mission.executive.report import Report
from bt_mission.sessions.session import Steps, finish
from bt_mission.views.terminal.marks import Marks, Span
from bt_mission.views.tui.dialogs import Chooser
from bt_mission.views.tui.keys import KEYS
from bt_mission.views.tui.view_app import ViewApp
from bt_mission.views.tui.watch_model import WatchModel

CHECK_S = 1.0
"""Wall time between two looks at who is there, once somebody is watched."""


class WatchApp(ViewApp):
    """Shows an executive of a graph, and passes on what the user wants of it.

    Args:
        graph: Where executives are found.
        marks: The terminal's signs.
        name: Of the executive to watch; None takes the only one, or asks.
        wait_s: Wall time after which it leaves when nobody was there to watch; None keeps looking.
            The return code is then 1.
    """

    keys = KEYS
    leaving = "leave; the mission runs on"
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
        """Who is watched."""
        return self.attachment.source

    def _look_round(self) -> None:
        """Look at who is there: always while nobody is watched, and now and then after that."""
        if self.source is not None and self._since_check.elapsed_s < CHECK_S:
            return
        self._since_check = Stopwatch()
        finding = self.attachment.look()
        if finding.is_new:
            self.outlook = WatchModel()
        elif finding.is_choice:
            self.action_choose()
        elif finding.text and self._wait_s is not None and self._wall.elapsed_s > self._wait_s:
            self.exit(return_code=1)
        if finding.text:
            self.tell(finding.text)

    def keys_now(self) -> list[str]:
        """Those that its state allows."""
        status = self.outlook.mission.status
        if status == "paused":
            keys = ["r resume", "s step", "x stop"]
        elif status in FINAL or not status:
            keys = []
        else:
            keys = ["p pause", "x stop"]
        others = ["b break", "/ search", "f follow", f"Tab {self.next_panel}", "? help", "q leave"]
        return [*keys, *others]

    # ---- wishes --------------------------------------------------------------------------

    def send_command(self, command: ControlRequest) -> None:
        """Pass a wish on to the executive."""
        if self.source is not None:
            self.source.send(command)

    def action_send(self, verb: str) -> None:
        """Pass on the wish of this name."""
        self.send_command(ControlRequest(Verb[verb]))

    def action_stop(self) -> None:
        """Stop, when asked twice in a row."""
        if self._may_stop:
            self._may_stop = False
            self.send_command(ControlRequest(Verb.STOP))
        else:
            self._may_stop = True
            self.tell("x again stops the mission; any other key does not")

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


TURN_S = 0.02
"""Wall time for which steps are taken at a stretch, before keys and pictures have their turn."""

SHORTEST_REST_S = 0.001


class RunApp(WatchApp):
    """Drives a session, and shows it. When it has ended, the picture stays until somebody leaves.

    Args:
        graph: Has the one executive.
        name: Its name.
        steps: The session on its way.
        interrupts: What the user's wish to leave goes to, as Ctrl-C does without a picture.
    """

    leaving = "end the mission; twice at once, or leave when it has ended"

    def __init__(
        self, graph: Graph, marks: Marks, name: str, steps: Steps, interrupts: InterruptSignals
    ) -> None:
        super().__init__(graph, marks, name)
        self.report: Report | None = None
        self._executive = name
        self._steps = steps
        self._interrupts = interrupts

    def on_mount(self) -> None:
        """Listen before the first step, and begin to drive once the first picture stands."""
        self.attach(self._executive)
        self.call_after_refresh(self.advance)

    def advance(self) -> None:
        """Take the steps that are due."""
        since = Stopwatch()
        wait_s = 0.0
        while wait_s <= 0 and since.elapsed_s < TURN_S:
            try:
                wait_s = next(self._steps)
            except StopIteration as end:
                self.report = end.value
                self.look()
                self.tell("the mission has ended: q leaves")
                return
        self.set_timer(max(wait_s, SHORTEST_REST_S), self.advance)

    def action_leave(self) -> None:
        """End the mission, as Ctrl-C does; leave once it has ended, or when asked twice."""
        if self.report is None:
            self._interrupts.note("the user")
            self.tell("the mission ends, every goal is seen to its end; q again leaves at once")
        if self.report is not None or self._interrupts.count > 1:
            self.exit()

    def send_command(self, command: ControlRequest) -> None:
        """Pass a wish on, as long as there is a mission that it could be about."""
        if self.report is None:
            super().send_command(command)
        else:
            self.tell("the mission has ended")

    def run_to_the_end(self) -> Report:
        """Show the mission until the user leaves; gives its report.

        If the view breaks, the mission is ended in good order all the same.
        """
        try:
            self.run()
        finally:
            if self.report is None:
                if not self._interrupts.count:
                    self._interrupts.note("the end of the view")
                self.report = finish(self._steps)
        return self.report
