"""The view of a run that shows only what missions say. Apart from the others, which load Rich."""

from __future__ import annotations

import sys

from bt_mission.events.events import Event, LogLine
from bt_mission.sessions.session import Run
from bt_mission.sessions.view import View


class Speech(View):
    """Prints what missions say to standard error, of several robots with the name before it."""

    def on_event(self, run: Run, event: Event) -> None:
        """Print a line that a mission says."""
        if isinstance(event, LogLine):
            print(f"{run.name}: {event.text}" if run.name else event.text, file=sys.stderr)
