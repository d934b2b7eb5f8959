"""Recordings of the missions that a server carries out, each in a file of its own."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from itertools import count
from pathlib import Path

from bt_mission.core.errors import BtMissionError
from bt_mission.executive.report import Report
from bt_mission.recording.writer import RunRecorder
from bt_mission.sessions.served_run import ServedRun

_NO_NAME = re.compile(r"[^\w.-]+", re.ASCII)


class ServedRecordings:
    """Records each mission that starts, from its first tick to its end.

    Args:
        folder: Takes the files, ``MISSION_001.mcap``, ...; None records nothing.
        say: Told of each file, and why there is none.
    """

    def __init__(self, folder: Path | None, say: Callable[[str], None]) -> None:
        self._folder = folder
        self._say = say
        self._open: list[RunRecorder] = []

    @classmethod
    def into(cls, folder: Path | None, say: Callable[[str], None]) -> ServedRecordings:
        """Return recordings into a folder, which is made.

        Raises:
            BtMissionError: For one that cannot be made, or written to.
        """
        if folder is not None:
            try:
                folder.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise BtMissionError(f"--record: {folder}: {error.strerror}") from error
            if not os.access(folder, os.W_OK | os.X_OK):
                raise BtMissionError(f"--record: the folder {folder} cannot be written to")
        return cls(folder, say)

    def begin(self, run: ServedRun) -> None:
        """Record a mission; one that cannot be recorded is carried out all the same."""
        if self._folder is None:
            return
        try:
            recorder = RunRecorder(run, free_file(self._folder, run.mission.name))
        except BtMissionError as error:
            self._say(f"not recorded: {error}")
            return
        self._open.append(recorder)

        def finish(report: Report) -> None:
            self._open.remove(recorder)
            recorder.finish(report.as_dict())
            lacks = f"; it lacks {recorder.missing}" if recorder.missing else ""
            self._say(f"  recorded to {recorder.file.path}{lacks}")

        run.end_listeners.append(finish)

    def close(self) -> None:
        """Close the file of a mission that was left."""
        while self._open:
            self._open.pop().close()


def free_file(folder: Path, mission: str) -> Path:
    """Return the first of ``MISSION_001.mcap``, ... in a folder that is not there yet."""
    stem = _NO_NAME.sub("_", mission).strip("._")[:80] or "mission"
    return next(path for n in count(1) if not (path := folder / f"{stem}_{n:03d}.mcap").exists())
