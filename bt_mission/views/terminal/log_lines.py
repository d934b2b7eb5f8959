"""The view of a run that shows only the lines of missions.

Separate from the others, which load Rich.
"""

from __future__ import annotations

import sys

from bt_mission.executive.events.events import Event, FaultChanged, LogLine
from bt_mission.executive.events.log import speech_of
from bt_mission.sessions.session import MissionRun
from bt_mission.sessions.view import View


class LogLineView(View):
    """Prints the lines of missions to standard error, after the name of one of several robots."""

    kinds = (LogLine, FaultChanged)

    def on_event(self, run: MissionRun, event: Event) -> None:
        """Print a line of a mission."""
        if (text := speech_of(event)) is not None:
            print(f"{run.name}: {text}" if run.name else text, file=sys.stderr)
