"""Views that show a session to people: lines, or live trees."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from bt_mission.executive.events.events import Event
from bt_mission.sessions.session import MissionRun, Onlooker, Session


class View(Onlooker):
    """Shows a session to people.

    It may lose its reader. A pipe that closes ends the missions in good order, as does a view that
    fails. Subclasses implement :meth:`open`, :meth:`on_event` and :meth:`refresh`.
    """

    kinds: tuple[type[Event], ...] = (Event,)
    """Of the events that it shows."""

    def open(self, session: Session) -> None:
        """Show the first picture."""

    def on_event(self, run: MissionRun, event: Event) -> None:
        """Show an event of one of the runs."""

    def refresh(self) -> None:
        """Draw what has changed since the last step."""

    def attach(self, session: Session) -> None:
        """Open the view, and pass it the events of each run."""
        self._show(lambda: self.open(session))
        for run in session.runs:
            run.executive.events.subscribe(partial(self._take, run), *self.kinds)

    def after_step(self) -> None:
        """Draw again, as long as the view has a reader."""
        self._show(self.refresh)

    def _take(self, run: MissionRun, event: Event) -> None:
        self._show(partial(self.on_event, run, event))

    def _show(self, show: Callable[[], None]) -> None:
        if self.why_left:
            return
        try:
            show()
        except BrokenPipeError:
            self.why_left = "the output was closed"
        except Exception as error:  # noqa: BLE001 - a view must not break the mission
            self.why_left = f"the view failed: {type(error).__name__}: {error}"
