"""Recordings of the missions of a server, each in a separate file."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from itertools import count
from pathlib import Path

from bt_mission.base.errors import BtMissionError
from bt_mission.recording.writer import RunRecorder
from bt_mission.sessions.session import Onlooker, Session

_NO_NAME = re.compile(r"[^\w.-]+", re.ASCII)


class ServedRecordings:
    """Records each mission of a server, from its first tick to its end.

    Args:
        folder: The folder of the files ``MISSION_001.mcap``, ...
        say: Called with a line for each file, and for each that cannot be written.

    Raises:
        BtMissionError: The folder cannot be created, or written to.
    """

    def __init__(self, folder: Path, say: Callable[[str], None]) -> None:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise BtMissionError(f"--record: {folder}: {error.strerror}", code="BT-1103") from error
        if not os.access(folder, os.W_OK | os.X_OK):
            raise BtMissionError(f"--record: the folder {folder} is not writable", code="BT-1103")
        self._folder = folder
        self._say = say
        self.are_whole = True
        """Whether each mission so far has a recording with everything in it."""

    def onlooker(self) -> Onlooker:
        """Return the onlooker that records one mission."""
        return _ServedRecording(self, self._folder, self._say)

    def note_incomplete(self) -> None:
        """Note that a recording lacks something."""
        self.are_whole = False


class _ServedRecording(Onlooker):
    """Records a mission; one that cannot be recorded still runs."""

    def __init__(
        self, recordings: ServedRecordings, folder: Path, say: Callable[[str], None]
    ) -> None:
        self._recordings = recordings
        self._folder = folder
        self._say = say
        self._session: Session
        self._recorder: RunRecorder | None = None

    def attach(self, session: Session) -> None:
        """Open the file."""
        self._session = session
        try:
            self._recorder = RunRecorder(session, free_file(self._folder, session.mission.name))
        except BtMissionError as error:
            self._say(f"not recorded: {error}")
            self._recordings.note_incomplete()

    def close(self) -> None:
        """Close the file, with the report of a mission that has ended."""
        recorder = self._recorder
        if recorder is None:
            return
        if self._session.is_done:
            recorder.finish(self._session.runner.report().as_dict())
            lacks = f"; it lacks {recorder.missing}" if recorder.missing else ""
            self._say(f"  recorded to {recorder.file.path}{lacks}")
        else:
            recorder.close()
        output = recorder.file.output
        if output.write_error is not None or output.is_deleted or output.remark:
            self._recordings.note_incomplete()


def free_file(folder: Path, mission: str) -> Path:
    """Return the first of ``MISSION_001.mcap``, ... in a folder that is not there yet."""
    stem = _NO_NAME.sub("_", mission).strip("._")[:80] or "mission"
    return next(path for n in count(1) if not (path := folder / f"{stem}_{n:03d}.mcap").exists())
