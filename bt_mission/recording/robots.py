"""Which robots have missions in a recording."""

from __future__ import annotations

from pathlib import Path

from bt_mission.recording.facts import RunFacts, robot_of
from bt_mission.recording.reading import RecordedFile


def recorded_robots(path: Path) -> list[str]:
    """Return the robots with missions in a recording, the first in front.

    For one robot that is the name of its namespace, which may be empty; it is empty for a bag, too.

    Raises:
        RecordingError: The file is invalid or cannot be opened.
    """
    file = RecordedFile(path)
    for _ in file.messages():
        break
    return [robot_of(node) for node in RunFacts(file.notes).missions] or [""]
