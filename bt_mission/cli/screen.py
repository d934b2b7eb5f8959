"""Trees of missions on the terminal, and whether it can show a full screen."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bt_mission.executive.events.mission_state import MissionState


def is_drawable() -> bool:
    """Can a picture stand on the terminal? Says so where it cannot."""
    if not (sys.stdout.isatty() and sys.stdin.isatty()):
        return False
    if os.environ.get("TERM", "dumb") in ("dumb", "unknown"):
        term = os.environ.get("TERM", "")
        print(
            f"TERM={term}: this terminal cannot show the full-screen view; printing plain lines",
            file=sys.stderr,
        )
        return False
    return True


def print_tree(mission: MissionState) -> None:
    """Print the tree of a mission as it is, no wider than the terminal."""
    from bt_mission.views.terminal.lines import whole_tree
    from bt_mission.views.terminal.marks import marks_for

    width = os.get_terminal_size().columns if sys.stdout.isatty() else None
    for line in whole_tree(mission, marks_for(sys.stdout.encoding), width):
        print(line)
