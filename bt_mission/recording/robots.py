"""Which robots have missions in a recording."""

from __future__ import annotations

from pathlib import Path

from bt_mission.recording.facts import RunFacts, robot_of
from bt_mission.recording.reading import RecordedFile


def recorded_robots(path: Path) -> list[str]:
    """Return the names of the robots whose missions are in a recording, the first in front.

    Of one robot that is the name of its namespace, which may be empty; of a bag it is empty, too.

    Raises:
        RecordingError: For a file that is none, or that cannot be opened.
    """
    file = RecordedFile(path)
    for _ in file.messages():
        break
    return [robot_of(node) for node in RunFacts(file.notes).missions] or [""]
