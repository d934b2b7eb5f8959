"""The recording of a run, which is kept where its test fails."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bt_mission.base.errors import BtMissionError
from bt_mission.recording.writer import RunRecorder
from bt_mission.sessions.stage import Stage


class FailureRecording:
    """Records a run from now on. An error of the recorder does not affect the test.

    Args:
        path: Where the recording is until somebody wants it.
    """

    def __init__(self, stage: Stage, path: Path) -> None:
        self._path = path
        self._recorder: RunRecorder | None = None
        self._error = ""
        self._has_ended = False
        try:
            self._recorder = RunRecorder(stage, path)
        except BtMissionError as error:
            self._error = str(error)

    @property
    def missing(self) -> str:
        """The missing parts, as text; empty if complete."""
        return self._error or (self._recorder.missing if self._recorder else "")

    def finish(self, summary: Mapping[str, Any]) -> None:
        """Write down that the run has ended."""
        if self._recorder is not None:
            self._has_ended = True
            self._recorder.finish(summary, summary.get("robots", ()))

    def leave(self, path: Path) -> bool:
        """Copy what is there by now; gives whether there is anything.

        Raises:
            OSError: Where that cannot be written.
        """
        if self._recorder is None or not self._path.exists():
            return False
        if not self._has_ended:
            self._recorder.file.flush()
        shutil.copyfile(self._path, path)
        return True

    def discard(self) -> None:
        """Delete the recording."""
        self._path.unlink(missing_ok=True)
