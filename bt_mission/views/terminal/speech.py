"""The view of a run that shows only what missions say. Apart from the others, which load Rich."""

from __future__ import annotations

import sys

from bt_mission.events.events import Event, FaultChanged, LogLine
from bt_mission.events.log import speech_of
from bt_mission.sessions.session import Run
from bt_mission.sessions.view import View


class Speech(View):
    """Prints what missions say to standard error, of several robots with the name before it."""

    kinds = (LogLine, FaultChanged)

    def on_event(self, run: Run, event: Event) -> None:
        """Print a line that a mission says."""
        if (text := speech_of(event)) is not None:
            print(f"{run.name}: {text}" if run.name else text, file=sys.stderr)
