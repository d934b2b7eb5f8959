"""The full-screen view of a mission that this process runs, step by step within its loop."""

from __future__ import annotations

from typing import Generic

from bt_mission.core.interrupts import InterruptSignals
from bt_mission.events.source import ControlRequest, Graph
from bt_mission.sessions.drive import R, StepDriver, Steps
from bt_mission.views.terminal.marks import Marks
from bt_mission.views.tui.app import WatchApp


class RunApp(WatchApp, Generic[R]):
    """Runs a session, and shows it. After its end the view stays until the user leaves.

    Args:
        graph: The executives of this process.
        name: The executive that is shown first.
        steps: The running session.
        interrupts: Receives the user's request to leave, as Ctrl-C does without a view.
    """

    leaving = "stop the mission; twice: at once; after its end: exit"

    def __init__(
        self, graph: Graph, marks: Marks, name: str, steps: Steps[R], interrupts: InterruptSignals
    ) -> None:
        super().__init__(graph, marks, name)
        self._executive = name
        self._step_driver = StepDriver(steps)
        self._interrupts = interrupts

    def on_mount(self) -> None:
        """Subscribe before the first step, and start after the first drawing."""
        self.attach(self._executive)
        self.call_after_refresh(self.advance)

    def advance(self) -> None:
        """Take the steps that are due."""
        wait_s = self._step_driver.advance()
        if not self._step_driver.is_over:
            self.set_timer(wait_s, self.advance)
            return
        if self.report is None:  # a step has raised an exception, which `run_to_the_end` raises
            self.exit()
            return
        self.look()
        self.show_notice("the mission has ended; q exits")

    @property
    def report(self) -> R | None:
        """Of the mission, once it has ended."""
        return self._step_driver.result

    def action_leave(self) -> None:
        """End the mission, as Ctrl-C does; leave once it has ended, or after a second request."""
        if self.report is None:
            self._interrupts.note("the user")
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
        try:
            self.run()
        finally:
            if self.report is None and not self._interrupts.count:
                self._interrupts.note("the end of the view")
            report = self._step_driver.finish()
        return report
