"""The view of a run that shows nothing. Apart from the others, for which Rich is loaded."""

from __future__ import annotations

import sys
from typing import Self

from bt_mission.core.wall_clock import Stopwatch
from bt_mission.events.events import NodeChanged
from bt_mission.sessions.session import Session


class Quiet:
    """Shows nothing; what the mission says goes to standard error."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def open(self, session: Session, wall: Stopwatch, /) -> None:
        """Nothing to show."""

    def on_change(self, change: NodeChanged) -> None:
        """Nothing to show."""

    def refresh(self) -> None:
        """Nothing to show."""

    def say(self, text: str) -> None:
        """Pass on what the mission says."""
        print(text, file=sys.stderr)
