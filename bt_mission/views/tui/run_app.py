"""The full-screen view of a mission that this process runs, step by step within its loop."""

from __future__ import annotations

import asyncio
import os
import signal
from typing import Generic

from textual import events
from textual.driver import Driver
from textual.message import Message

from bt_mission.base.clock_watch import ClockWatch, told_by
from bt_mission.base.interrupts import InterruptSignals
from bt_mission.base.text import escape_control
from bt_mission.executive.events.source import ControlRequest, Graph
from bt_mission.sessions.drive import R, StepDriver, Steps
from bt_mission.views.terminal.marks import Marks
from bt_mission.views.tui.app import WatchApp
from bt_mission.views.tui.view_app import NOTICE_S

LEAVING_KEYS = ("q", "ctrl+c", "ctrl+q")

SIGNAL_LOOK_S = 0.1
"""Between two looks for a signal once the mission has ended, s of wall time."""

SHORTEST_REST_S = 0.001
"""Wall time that the screen has between two turns of a mission that does not wait."""


class RunApp(WatchApp, Generic[R]):
    """Runs a session, and shows it. After its end the view stays until the user leaves.

    Args:
        graph: The executives of this process.
        name: The executive that is shown first.
        steps: The running session.
        interrupts: Receives the user's request to leave, as Ctrl-C does without a view.
        watch: Finds the code of users that holds the thread of this view.
    """

    leaving = "stop the mission; twice: at once; after its end: exit"

    def __init__(
        self,
        graph: Graph,
        marks: Marks,
        name: str,
        steps: Steps[R],
        interrupts: InterruptSignals,
        watch: ClockWatch | None = None,
    ) -> None:
        self._watch = watch
        super().__init__(graph, marks, name)
        self._executive = name
        self._step_driver = StepDriver(steps)
        self._interrupts = interrupts

    def get_driver_class(self) -> type[Driver]:
        """Return Textual's driver, which also leaves while this thread is held."""
        kind, watch = super().get_driver_class(), self._watch
        return kind if watch is None else _leaving(kind, watch)

    def _tell(self, line: str) -> None:
        """Show a line in the last row, from another thread: this one is held."""
        if self._driver is not None:
            self._notice, self._notice_until_s = line, self._wall.elapsed_s + NOTICE_S
            self._driver.write(
                f"\x1b7\x1b[999;1H\x1b[2K\x1b[1;31m{escape_control(line)}\x1b[0m\x1b8"
            )
            self._driver.flush()

    def _give_terminal_back(self) -> None:
        if self._driver is not None:
            self._driver.stop_application_mode()
            self._driver.close()

    def on_mount(self) -> None:
        """Subscribe before the first step, and start after the first drawing."""
        self.attach(self._executive)
        self.call_after_refresh(self.advance)

    def advance(self) -> None:
        """Take the steps that are due."""
        wait_s = self._step_driver.advance()
        if not self._step_driver.is_over:
            # Not `set_timer`: a timer of Textual that is late when it starts never fires.
            rest_s = max(wait_s, SHORTEST_REST_S)
            asyncio.get_running_loop().call_later(rest_s, self.call_next, self.advance)
            return
        if self.report is None:  # a step has raised an exception, which `run_to_the_end` raises
            self.exit()
            return
        self.look()
        self.show_notice("the mission has ended; q exits")
        self._leave_on_signal()

    def _leave_on_signal(self) -> None:
        """Exit at a signal, also later: nobody may be there to press q on a closed terminal."""
        if self._interrupts.signal:
            self.exit()
        else:
            asyncio.get_running_loop().call_later(SIGNAL_LOOK_S, self._leave_on_signal)

    @property
    def report(self) -> R | None:
        """Of the mission, once it has ended."""
        return self._step_driver.result

    def action_leave(self) -> None:
        """End the mission, as Ctrl-C does; leave once it has ended, or after a second request."""
        if self.report is None:
            self._interrupts.note("user request")
            self.show_notice("stopping; waiting until all goals have ended; q again exits at once")
        if self.report is not None or self._interrupts.count > 1:
            self.exit()

    def send_command(self, command: ControlRequest) -> None:
        """Pass a wish on, as long as there is a mission that it could be about."""
        if self.report is None:
            super().send_command(command)
        else:
            self.show_notice("the mission has ended")

    def run_to_the_end(self) -> R:
        """Show the mission until the user leaves. Return its report.

        If the view raises, the mission still ends in an orderly way.
        """
        if self._watch is not None:
            self._watch.last_words.insert(0, self._give_terminal_back)
        try:
            with told_by(self._tell):
                self.run()
        finally:
            if self.report is None and not self._interrupts.count:
                self._interrupts.note("the end of the view")
            report = self._step_driver.finish()
        return report


def _leaving(kind: type[Driver], watch: ClockWatch) -> type[Driver]:
    """Return a driver that sends this process Ctrl-C for the keys of leaving while it is held.

    A terminal in raw mode sends no signal, and the thread that takes the keys is held.
    """

    class LeavingDriver(kind):  # type: ignore[valid-type,misc]  # known when it is made
        def process_message(self, message: Message) -> None:
            is_key = isinstance(message, events.Key) and message.key in LEAVING_KEYS
            if is_key and watch.is_held:
                os.kill(os.getpid(), signal.SIGINT)
            else:
                super().process_message(message)

    return LeavingDriver
