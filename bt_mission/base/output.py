"""Files that commands write: an existing one stays until the new one is complete.

A whole file at once: :func:`write_file` and :func:`new_file`. A file that grows during a run:
:class:`OutputFile`. A device or a pipe is written to directly. A symbolic link is followed.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from io import BufferedWriter
from pathlib import Path, PurePosixPath
from typing import BinaryIO, Literal

from bt_mission.base.errors import BtMissionError

DELETED = "everything (the file was deleted while it was written)"
"""The remark of such a file."""

LONGEST_STEM = 200
"""Characters of a file's name in the name of its part; file systems take 255 bytes."""


def within(folder: Path, name: str) -> Path:
    """Return a path in a folder that may come from others: no link is followed out of it.

    Args:
        folder: As the user has named it; it may be a link itself.
        name: From there, with ``/`` between folders.

    Raises:
        BtMissionError: For a name that leads out of the folder, or through a symbolic link.
    """
    parts = PurePosixPath(name).parts
    if not parts or parts[0] == "/" or ".." in parts:
        raise BtMissionError(f"{folder}: '{name}' is outside the folder", code="BT-1103")
    path = folder
    for part in parts:
        path = path / part
        if path.is_symlink():
            raise BtMissionError(
                f"{path} is a symbolic link, which is not followed in a folder of results",
                code="BT-1103",
            )
    return path


def make_folder(path: Path) -> None:
    """Make a folder, and those above.

    Raises:
        BtMissionError: It cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except FileExistsError as error:
        message = f"cannot make the folder {path}: a file has that name"
        raise BtMissionError(message, code="BT-1103") from error
    except OSError as error:
        raise cannot_write(path, error) from error


def make_folder_of(path: Path) -> None:
    """Make the folder of a file, and those above.

    Raises:
        BtMissionError: It cannot be made.
    """
    make_folder(path.parent)


def write_file(
    path: Path, content: str | bytes, *, mode: int | None = None, follows: bool = True
) -> None:
    """Write all of a file; a text as UTF-8. See `new_file`.

    Raises:
        BtMissionError: It cannot be written. An existing file is unchanged.
    """
    with new_file(path, mode=mode, follows=follows) as stream:
        stream.write(content if isinstance(content, bytes) else content.encode(errors="replace"))


@contextmanager
def new_file(path: Path, *, mode: int | None = None, follows: bool = True) -> Iterator[BinaryIO]:
    """Open a file to write all of it; it gets its name at the end of the block.

    Args:
        path: Its path.
        mode: Its permissions; None are those of an existing file, or those of the user's new files.
        follows: Whether the target of a symbolic link is written; if not, the link is replaced.

    Raises:
        BtMissionError: It cannot be written. An existing file is unchanged.
    """
    try:
        target = path.resolve() if follows else path
        if follows and _is_special(target):
            with target.open("wb") as stream:
                yield stream
            return
        part = target.with_name(f".{os.urandom(8).hex()}.part")
        try:
            # Nobody may read meanwhile who may not read the file.
            with _opened(part, "xb", _mode_of(target) if mode is None else mode) as stream:
                yield stream
                if mode is None:
                    _finish(stream, target)
            part.replace(target)
        except BaseException:
            with suppress(OSError):
                part.unlink(missing_ok=True)
            raise
    except (OSError, RuntimeError) as error:  # RuntimeError: a ring of links
        raise cannot_write(path, error) from error


class OutputFile:
    """A file that grows while something runs, and can be read wherever it is cut.

    A new one has its name from the start. Where a file of that name is there, the new one grows
    beside it as ``NAME.part.SUFFIX``, and replaces it when it is closed whole. So a process that is
    killed leaves what it has written, and what was there before.

    Once a write fails, nothing more is written, and :attr:`write_error` says why.

    Args:
        path: Where it is written.
        stream: Write here instead.

    Raises:
        BtMissionError: When it cannot be opened.
    """

    def __init__(self, path: Path, stream: BinaryIO | None = None) -> None:
        self.path = path
        self.place = path
        """Its present place: :attr:`path`, or beside it until it is closed complete."""
        self.write_error: str | None = None
        self._is_named = stream is None
        try:
            if stream is None and path.is_file():
                target = path.resolve() if path.is_symlink() else path
                name = f"{target.stem[:LONGEST_STEM]}.part{target.suffix}"
                self.place = target.with_name(name)
            if stream is None:
                stream = _opened(self.place, "wb", _mode_of(path))
            self.stream = stream
        except OSError as error:
            raise cannot_write(path, error) from error

    @property
    def is_deleted(self) -> bool:
        """Whether the file was deleted while it is written."""
        return self._is_named and not self.place.exists()

    @property
    def remark(self) -> str:
        """A remark on a closed file; empty for a complete one."""
        return "" if self.place == self.path else f"{self.path} is unchanged"

    def attempt(self, write: Callable[[], object]) -> None:
        """Write, unless a write has failed."""
        if self.write_error is None:
            try:
                write()
            except OSError as error:
                self.abandon(error.strerror or str(error))

    def abandon(self, why: str) -> None:
        """Write nothing more."""
        if self.write_error is None:
            self.write_error = why

    def close(self, *, replaces: bool = True) -> None:
        """Close it; further calls do nothing.

        Args:
            replaces: Whether a complete file replaces the existing one.
        """
        if self.stream.closed:
            return
        if replaces and self.place != self.path:
            self.attempt(lambda: _finish(self.stream, self.path))
        if self.write_error is not None and isinstance(self.stream, BufferedWriter):
            self.stream.raw.close()  # without what is still buffered, which is missing by now
        try:
            self.stream.close()
        except OSError as error:  # buffered data does not fit; the file is still closed
            self.abandon(error.strerror or str(error))
        if replaces and self.place != self.path:
            self.attempt(self._replace)

    def _replace(self) -> None:
        self.place.replace(self.path.resolve())
        self.place = self.path


def cannot_write(path: Path, error: OSError | RuntimeError) -> BtMissionError:
    """Return the error for a file that cannot be written."""
    reason = getattr(error, "strerror", None) or error
    return BtMissionError(f"cannot write {path}: {reason}", code="BT-1103")


def _is_special(path: Path) -> bool:
    """Return whether it is a device, a pipe, or a folder, which cannot be opened."""
    return path.exists() and not path.is_file()


def _opened(path: Path, how: Literal["wb", "xb"], mode: int) -> BinaryIO:
    """Open a file to write it; a new one gets its permissions at once."""
    return open(path, how, opener=partial(os.open, mode=mode))


def _mode_of(target: Path) -> int:
    """Return the permissions of a file; those of a new one are cut by the user's mask."""
    try:
        return stat.S_IMODE(target.stat().st_mode)
    except FileNotFoundError:
        return 0o666


def _finish(stream: BinaryIO, target: Path) -> None:
    """Flush all of a file to the disk, with the permissions of the one that it replaces."""
    stream.flush()
    if target.exists():
        os.fchmod(stream.fileno(), stat.S_IMODE(target.stat().st_mode))
        os.fsync(stream.fileno())
