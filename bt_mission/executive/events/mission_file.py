"""The file of a running mission: is it still the one that runs?"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Self

from bt_mission.base.errors import BtMissionError
from bt_mission.base.yaml.document import read_source

if TYPE_CHECKING:
    from bt_mission.language.mission import Mission

CHANGED = "file on disk differs"
"""The note in views."""


def sha256_of(text: str) -> str:
    """Return the hash of a mission's text, in hexadecimal."""
    return hashlib.sha256(text.encode()).hexdigest()


@dataclass(frozen=True)
class MissionOrigin:
    """The file of a mission, on the machine of its executive, and the hash of what runs."""

    path: str
    sha256: str

    @classmethod
    def of(cls, mission: Mission) -> Self:
        """Return the file of a mission; the path is empty if there is no file."""
        path = Path(mission.file)
        return cls(str(path.absolute()) if path.is_file() else "", sha256_of(mission.document.text))


class FileCheck:
    """Notices that the file of a mission has another text than the mission that runs.

    A file that does not exist here, as on another machine, is never noticed. Included files are not
    compared.
    """

    def __init__(self) -> None:
        self._file: MissionOrigin | None = None
        self._stamp: tuple[int, int] | None = None
        self.note = ""
        """The note for views; empty while the file is the one that runs."""

    def look(self, file: MissionOrigin | None) -> None:
        """Look at the file of a mission; it is read only if it has changed."""
        if file is None or not file.path:
            self.note = ""
            return
        try:
            status = Path(file.path).stat()
        except (OSError, ValueError):
            self._stamp, self.note = None, ""
            return
        stamp = (status.st_mtime_ns, status.st_size)
        if file == self._file and stamp == self._stamp:
            return
        self._file, self._stamp = file, stamp
        try:
            is_other = sha256_of(read_source(file.path)) != file.sha256
        except BtMissionError:
            is_other = False
        self.note = CHANGED if is_other else ""
