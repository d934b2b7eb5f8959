"""The files that the editor may read and write: those of one folder, and nothing else."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any

from bt_mission.core.errors import BtMissionError
from bt_mission.core.files import SUFFIXES, kind_of
from bt_mission.core.yaml.document import MAX_BYTES, read_source

MOST_FILES = 500
MOST_LEVELS = 4
"""Folders below the root that are searched for files."""

UNSAVED, TRIAL = ".unsaved", ".yaml"
"""Endings of the files beside a file: its unsaved text, and the text that a command uses."""
COMMANDS = ("run", "fork", "prove", "revise")
"""The commands that use one."""


class EditError(BtMissionError):
    """A file that the editor cannot read or write."""

    code = "BT-1302"


class ConflictError(BtMissionError):
    """A file that has changed on disk since it was opened; `theirs` is its text now."""

    code = "BT-1303"

    def __init__(self, name: str, theirs: str | None) -> None:
        what = "has changed on disk" if theirs is not None else "no longer exists"
        super().__init__(f"{name} {what} since it was opened; nothing was saved")
        self.theirs = theirs


@dataclass(frozen=True)
class Loaded:
    """A file: its text with line feeds, and the line ends of the file."""

    text: str
    newline: str


class Workspace:
    """The YAML files of a folder.

    Args:
        root: The folder, or a single file.
    """

    def __init__(self, root: Path) -> None:
        self.only = root.name if root.is_file() or root.suffix in SUFFIXES else None
        self.root = (root.parent if self.only else root).resolve()

    def files(self) -> list[dict[str, Any]]:
        """Return the names of the files, with their kinds and whether there is unsaved text."""
        if self.only is not None:
            return [self._row(self.only)]
        return [self._row(name) for name in self._names()]

    def path(self, name: str) -> Path:
        """Return the path of a file by its name in the folder.

        Raises:
            EditError: The name is not that of a YAML file in the folder.
        """
        path = self.root / name
        is_valid = (
            path.suffix in SUFFIXES
            and "\0" not in name
            and len(name) < 250
            and not any(part.startswith(".") for part in Path(name).parts)
            and (self.only is None or name == self.only)
        )
        if not is_valid or not path.resolve().is_relative_to(self.root):
            raise EditError(f"{name!r} is not a YAML file of this folder")
        return path

    def read(self, name: str) -> Loaded:
        """Return a file; a new one is empty. Raises InputError or EditError."""
        path = self.path(name)
        if not path.exists():
            return Loaded("", "\n")
        text = read_source(path)
        newline = "\r\n" if "\r\n" in text and "\n" not in text.replace("\r\n", "") else "\n"
        return Loaded(text.replace("\r\n", "\n") if newline == "\r\n" else text, newline)

    def save(self, name: str, text: str, base: str, *, is_forced: bool = False) -> None:
        """Replace a file as a whole, if its text is still the base.

        Raises:
            ConflictError: The file has changed.
            EditError: The file cannot be written.
        """
        path = self.path(name)
        now = self.read(name)
        if now.text != base and not is_forced:
            raise ConflictError(name, now.text if path.exists() else None)
        self._write(path, text.replace("\n", now.newline))
        self.drop_draft(name)

    def create(self, name: str) -> None:
        """Write an empty file in a folder that exists.

        Raises:
            EditError: The name is taken or invalid, or the file cannot be written.
        """
        self._write(self._free(name), "")

    def rename(self, name: str, other: str) -> None:
        """Give a file another name in the folder, together with its unsaved text.

        Raises:
            EditError: A name is invalid, the new one is taken, or the file cannot be renamed.
        """
        path, target = self._existing(name), self._free(other)
        draft = self._beside(name, UNSAVED)
        try:
            path.rename(target)
            if draft.exists():
                draft.rename(self._beside(other, UNSAVED))
        except OSError as error:
            raise EditError(f"{name}: cannot be renamed ({error.strerror})") from None

    def delete(self, name: str, base: str) -> None:
        """Delete a file, if its text is still the base. Unsaved text goes, too.

        Raises:
            ConflictError: The file has changed.
            EditError: The file does not exist, or cannot be deleted.
        """
        path = self._existing(name)
        if (now := self.read(name).text) != base:
            raise ConflictError(name, now)
        try:
            path.unlink()
        except OSError as error:
            raise EditError(f"{name}: cannot be deleted ({error.strerror})") from None
        self.drop_draft(name)

    def _existing(self, name: str) -> Path:
        self._refuse_single()
        path = self.path(name)
        if not path.is_file():
            raise EditError(f"{name}: no such file")
        return path

    def _free(self, name: str) -> Path:
        self._refuse_single()
        path = self.path(name)
        if os.path.lexists(path):
            raise EditError(f"{name}: the file already exists")
        if not path.parent.is_dir():
            raise EditError(f"{name}: the folder does not exist")
        return path

    def _refuse_single(self) -> None:
        if self.only is not None:
            raise EditError(f"only {self.only} is open: start the editor with a folder")

    def save_beside(self, name: str, text: str) -> None:
        """Write a new file in the folder, also beside the only file. Raises EditError."""
        Workspace(self.root).save(name, text, "")

    def free_name(self, name: str, ending: str) -> str:
        """Return the name of a file that does not exist: that of a file with an ending."""
        stem = Path(name).with_suffix("")
        names = (f"{stem}_{ending}{number or ''}.yaml" for number in count())
        return next(free for free in names if not (self.root / free).exists())

    def draft(self, name: str) -> str | None:
        """Return the unsaved text beside a file; None without one."""
        try:
            text = self._beside(name, UNSAVED).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError):
            return None
        return text if text != self.read(name).text else None

    def keep_draft(self, name: str, text: str) -> str:
        """Keep unsaved text beside a file; return why it cannot be kept, or an empty text."""
        if len(text) > MAX_BYTES:
            return f"the text exceeds {MAX_BYTES:,} bytes"
        try:
            if text == self.read(name).text:
                self.drop_draft(name)
            else:
                self._write(self._beside(name, UNSAVED), text)
        except BtMissionError as error:
            return str(error)
        return ""

    def drop_draft(self, name: str) -> None:
        """Delete the unsaved text beside a file."""
        with suppress(OSError):
            self._beside(name, UNSAVED).unlink()

    def trial(self, name: str, text: str, command: str) -> Path:
        """Write a text beside its file, for a command; return its path."""
        path = self._beside(name, f".{command}{TRIAL}")
        self._write(path, text)
        return path

    def drop_trials(self) -> None:
        """Delete the texts of commands that an editor has left behind which was killed."""
        for row in self.files():
            for command in COMMANDS:
                with suppress(OSError):
                    self._beside(row["name"], f".{command}{TRIAL}").unlink()

    def _beside(self, name: str, suffix: str) -> Path:
        path = self.path(name)
        return path.with_name(f".{path.name}{suffix}")

    def _row(self, name: str) -> dict[str, Any]:
        path = self.root / name
        try:
            kind = kind_of(path) if path.exists() else "mission"
        except BtMissionError:
            kind = "mission"
        return {"name": name, "kind": kind, "is_unsaved": self._beside(name, UNSAVED).exists()}

    def _names(self) -> Iterator[str]:
        count = 0
        for folder, folders, names in os.walk(self.root):
            level = len(Path(folder).relative_to(self.root).parts)
            folders[:] = sorted(
                sub for sub in folders if sub[0] not in "._" and level < MOST_LEVELS
            )
            drafts = (name[1:].removesuffix(UNSAVED) for name in names if name.endswith(UNSAVED))
            for name in sorted({*names, *drafts}):
                path = Path(folder) / name
                is_shown = path.suffix in SUFFIXES and name[0] != "." and count < MOST_FILES
                if is_shown and path.resolve().is_relative_to(self.root):
                    count += 1
                    yield str(path.relative_to(self.root))

    @staticmethod
    def _write(path: Path, text: str) -> None:
        """Replace a file: either all of the new text is there afterwards, or the old one."""
        try:
            mode = path.stat().st_mode & 0o777 if path.exists() else 0o644
            with tempfile.NamedTemporaryFile(
                "w", dir=path.parent, prefix=".", delete=False, encoding="utf-8", newline=""
            ) as file:
                file.write(text)
            try:
                Path(file.name).chmod(mode)
                Path(file.name).replace(path)
            except OSError:
                Path(file.name).unlink()
                raise
        except OSError as error:
            raise EditError(f"{path.name}: cannot be written ({error.strerror})") from None
