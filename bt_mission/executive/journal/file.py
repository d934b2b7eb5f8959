"""Records on disk, appended one by one, that show whether any of them is torn, lost or changed.

A record is a line: the CRC-32 of all texts so far, in eight hexadecimal digits, a space, and the
text, which is JSON. The kernel has a record when :meth:`JournalFile.append` returns, so the death
of the process loses none; a loss of power may. A file that has grown beyond a bound is written anew
with the records that still matter, and takes the place of the old one at once.
"""

from __future__ import annotations

import fcntl
import json
import os
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bt_mission.core.errors import BtMissionError

FORMAT = "bt-mission journal 1"
BOUND = 4 * 2**20
"""Bytes after which a journal is written anew."""


class JournalFile:
    """A journal that is open for appending; nobody else can open it meanwhile.

    Args:
        path: Of the file; it is made if it is not there.
        bound: Bytes, see :data:`BOUND`.

    Raises:
        BtMissionError: When it cannot be opened, or somebody else has it open.
    """

    def __init__(self, path: Path, bound: int = BOUND) -> None:
        self.path = path
        self._bound = bound
        self._crc = 0
        self._size = 0
        self._file = self._open(path)

    @property
    def is_long(self) -> bool:
        """Should it be written anew?"""
        return self._size > self._bound

    def read(self) -> list[dict[str, Any]]:
        """Every record, from the first; what is appended later follows them.

        Raises:
            BtMissionError: When the file is no journal, or a record is torn.
        """
        try:
            data = self._pread()
        except OSError as error:
            raise BtMissionError(f"{self.path}: {error.strerror}") from error
        records: list[dict[str, Any]] = []
        crc = 0
        lines = data.split(b"\n")
        for number, line in enumerate(lines[:-1], 1):
            crc = self._checked(line, crc, number)
            records.append(json.loads(line[9:]))
        if lines[-1]:
            raise self._torn(len(lines), "it does not end")
        if not records or records[0].get("format") != FORMAT:
            raise BtMissionError(f"{self.path}: not a journal of this version of bt-mission")
        self._crc, self._size = crc, len(data)
        return records

    def append(self, record: dict[str, Any]) -> None:
        """Add a record.

        Raises:
            BtMissionError: When it cannot be written.
        """
        line, self._crc = _line(record, self._crc)
        self._size += len(line)
        self._write(self._file, line)

    def rewrite(self, records: Sequence[dict[str, Any]]) -> None:
        """Put these records in the place of all.

        Raises:
            BtMissionError: When they cannot be written.
        """
        new = self.path.with_name(self.path.name + ".new")
        crc, lines = 0, []
        for record in records:
            line, crc = _line(record, crc)
            lines.append(line)
        file = self._open(new)
        try:
            os.ftruncate(file, 0)
            self._write(file, b"".join(lines))
            os.fsync(file)
            new.replace(self.path)
        except OSError as error:
            os.close(file)
            raise BtMissionError(f"{self.path}: cannot write: {error.strerror}") from error
        os.close(self._file)
        self._file, self._crc = file, crc
        self._size = sum(len(line) for line in lines)
        # What must stay has no bound; it is not written anew for each record, though.
        self._bound = max(self._bound, 2 * self._size)

    def close(self) -> None:
        """Let others have it."""
        os.close(self._file)

    def _open(self, path: Path) -> int:
        try:
            file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o644)
        except (OSError, ValueError) as error:
            why = error.strerror if isinstance(error, OSError) else str(error)
            raise BtMissionError(f"{path}: cannot open the journal: {why}") from error
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            os.close(file)
            raise BtMissionError(f"{path}: a mission that runs has this journal open") from error
        return file

    def _write(self, file: int, data: bytes) -> None:
        view = memoryview(data)
        try:
            while view:
                view = view[os.write(file, view) :]
        except OSError as error:
            raise BtMissionError(
                f"{self.path}: cannot write the journal: {error.strerror}"
            ) from error

    def _pread(self) -> bytes:
        parts, offset = [], 0
        while part := os.pread(self._file, 2**20, offset):
            parts.append(part)
            offset += len(part)
        return b"".join(parts)

    def _checked(self, line: bytes, before: int, number: int) -> int:
        crc = zlib.crc32(line[9:], before)
        if line[:9] != b"%08x " % crc:
            if number == 1 and b'"format"' not in line:
                raise BtMissionError(f"{self.path}: not a journal")
            raise self._torn(number, "its checksum is wrong")
        return crc

    def _torn(self, number: int, why: str) -> BtMissionError:
        return BtMissionError(
            f"{self.path}:{number}: torn: {why}; the {number - 1} records before it are sound, but "
            "what the mission did after them is not known: start it anew"
        )


def _line(record: dict[str, Any], before: int) -> tuple[bytes, int]:
    text = json.dumps(record, separators=(",", ":")).encode()
    crc = zlib.crc32(text, before)
    return b"%08x %s\n" % (crc, text), crc
