"""The files that the editor may read and write: those of one folder, and nothing else."""

from __future__ import annotations

import os
import re
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from secrets import token_hex
from typing import Any

from bt_mission.base.diagnostics import InputError
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import SUFFIXES, kind_of
from bt_mission.base.output import write_file
from bt_mission.base.text import escape_control
from bt_mission.base.yaml.document import MAX_BYTES, contents
from bt_mission.commands.edit.web.line_ends import EditedText

MOST_FILES = 500
MOST_LEVELS = 4
"""Folders below the root that are searched for files."""
MOST_NAMES = 50_000
"""Names of any files that are searched for those that are shown."""
MOST_HIDDEN = 20

MOST_DRAFTS = 5
"""Unsaved texts of a file that are offered."""
MOST_READ = 50
"""The newest of them, which are read."""

LONGEST_NAME = 200
"""Bytes of the name of a file; file systems take 255, also with the endings below."""

UNSAVED, TRIAL = ".unsaved", ".yaml"
"""Endings of the files beside a file: the unsaved texts of pages, and texts of commands."""
COMMANDS = ("run", "fork", "prove", "revise")
"""The commands that use one."""

_PAGE = re.compile(r"[0-9A-Za-z-]{1,36}", re.ASCII)
_DRAFT = re.compile(r"\.(?P<name>.+\.ya?ml)(?:\.(?P<page>[0-9A-Za-z-]{1,36}))?\.unsaved", re.ASCII)
_TRIAL = re.compile(rf"\..+\.(?P<process>\d+)-[0-9a-f]+\.(?:{'|'.join(COMMANDS)})\.yaml", re.ASCII)
PRIVATE = 0o600
_TOO_LARGE = f"the text exceeds {MAX_BYTES:,} bytes, the limit of what is read"


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
class Draft:
    """The unsaved text of a page; `page` is empty if it is not known."""

    page: str
    text: str
    saved_s: float
    """When, s since 1970."""


@dataclass
class Listing:
    """The files of a folder.

    Attributes:
        files: The names of those that are shown, and whether there is unsaved text.
        hidden: The names of those that are not shown, since they are not text.
        is_cut: Whether there are more than can be shown, or searched for.
    """

    files: dict[str, bool] = field(default_factory=dict)
    hidden: set[str] = field(default_factory=set)
    is_cut: bool = False


class Workspace:
    """The YAML files of a folder.

    Args:
        root: The folder, or a single file.
    """

    def __init__(self, root: Path) -> None:
        self.only = root.name if root.is_file() or root.suffix in SUFFIXES else None
        self.root = (root.parent if self.only else root).resolve()

    def listing(self) -> dict[str, Any]:
        """Return the files with their kinds and whether there is unsaved text, and what is hidden.

        See `Listing`.
        """
        listing = self._scan()
        hidden = sorted(listing.hidden)
        if more := len(hidden[MOST_HIDDEN:]):
            hidden[MOST_HIDDEN:] = [f"and {more} more"]
        files = [
            {"name": name, "kind": self._kind(name), "is_unsaved": is_unsaved}
            for name, is_unsaved in listing.files.items()
        ]
        return {"files": files, "hidden": hidden, "is_cut": listing.is_cut}

    def path(self, name: str) -> Path:
        """Return the path of a file by its name in the folder.

        Raises:
            EditError: The name is not that of a YAML file in the folder.
        """
        path = self.root / name
        is_valid = (
            path.suffix in SUFFIXES
            and name.isprintable()
            and _is_text(name)
            and len(os.fsencode(path.name)) <= LONGEST_NAME
            and not any(part.startswith(".") for part in Path(name).parts)
            and (self.only is None or name == self.only)
            and str(Path(name)) == name  # a file has one name, on which its pages agree
            and not Path(name).is_absolute()
        )
        if not is_valid or not self._is_inside(path):
            raise EditError(f"{name!r} is not a YAML file of this folder")
        return path

    def _is_inside(self, path: Path) -> bool:
        try:
            return path.resolve().is_relative_to(self.root)
        except (OSError, RuntimeError):  # a ring of links
            return False

    def read(self, name: str) -> EditedText:
        """Return a file; a new one is empty. Raises InputError or EditError."""
        path = self.path(name)
        if not os.path.lexists(path):
            return EditedText()
        return EditedText.of(contents(path), str(path))

    def save(self, name: str, text: str, base: str, *, is_forced: bool = False) -> None:
        """Replace a file as a whole, if its text is still the base.

        Lines that have not changed keep their bytes. The target of a symbolic link is written.

        Raises:
            ConflictError: The file has changed.
            EditError: The file cannot be written.
        """
        path = self.path(name)
        now = self.read(name)
        if now.text != base and not is_forced:
            raise ConflictError(name, now.text if os.path.lexists(path) else None)
        content = now.changed_to(text)
        if len(content) > MAX_BYTES:
            raise EditError(f"{name}: cannot be saved ({_TOO_LARGE}); nothing was written")
        _write(path, content)

    def create(self, name: str) -> None:
        """Write an empty file in a folder that exists.

        Raises:
            EditError: The name is taken or invalid, or the file cannot be written.
        """
        _write(self._free(name), b"")

    def rename(self, name: str, other: str) -> None:
        """Give a file another name in the folder, together with its unsaved text.

        Raises:
            EditError: A name is invalid, the new one is taken, or the file cannot be renamed.
        """
        path, target = self._existing(name), self._free(other)
        drafts = [(draft, self._draft(other, page)) for draft, page in self._drafts_of(name)]
        try:
            path.rename(target)
            for draft, renamed in drafts:
                draft.rename(renamed)
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
        self.drop_drafts(name, [page for _, page in self._drafts_of(name)])

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

    # ---- unsaved texts -------------------------------------------------------------------

    def drafts(self, name: str) -> list[Draft]:
        """Return the last unsaved texts beside a file that differ from it, the newest first."""
        known = {self.read(name).text}
        dated = [(_saved_s(path), path, page) for path, page in self._drafts_of(name)]
        newest = []
        for saved_s, path, page in sorted(dated, reverse=True)[:MOST_READ]:
            try:
                text = EditedText.of(contents(path, follows=False), path.name).text
            except InputError:  # a link, a pipe, another encoding: not of the editor
                continue
            if text not in known:
                known.add(text)
                newest.append(Draft(page, text, saved_s))
        return newest[:MOST_DRAFTS]

    def keep_draft(self, name: str, page: str, text: str) -> str:
        """Keep the unsaved text of a page; return why it cannot be kept, or an empty text."""
        content = text.encode()
        if len(content) > MAX_BYTES:
            return _TOO_LARGE
        try:
            if self._has(name, text):
                self.drop_drafts(name, [page])
            else:
                path = self.path(name)
                _write(self._draft(name, page), content, _mode_beside(path))
        except EditError as error:
            return str(error)
        return ""

    def _has(self, name: str, text: str) -> bool:
        """Return whether a file has this text; one that cannot be read has another."""
        try:
            return self.read(name).text == text
        except InputError:
            return False

    def drop_drafts(self, name: str, pages: list[str]) -> None:
        """Delete unsaved texts beside a file."""
        for page in pages:
            with suppress(OSError):
                self._draft(name, page).unlink()

    def _draft(self, name: str, page: str) -> Path:
        if page and _PAGE.fullmatch(page) is None:
            raise EditError("an invalid name of a page")
        path = self.path(name)
        return path.with_name(f".{path.name}{page and f'.{page}'}{UNSAVED}")

    def _drafts_of(self, name: str) -> list[tuple[Path, str]]:
        """Return the paths of unsaved texts of a file, with the names of their pages."""
        path = self.path(name)
        try:
            names = os.listdir(path.parent)  # noqa: PTH208 - names only
        except OSError:
            return []
        matches = filter(None, map(_DRAFT.fullmatch, names))
        return [
            (path.with_name(match.string), match["page"] or "")
            for match in matches
            if match["name"] == path.name
        ]

    # ---- texts of commands ---------------------------------------------------------------

    def trial(self, name: str, text: str, command: str) -> Path:
        """Write a text beside its file, for a command; return its path, which is a new one."""
        path = self.path(name)
        trial = path.with_name(f".{path.name}.{os.getpid()}-{token_hex(4)}.{command}{TRIAL}")
        _write(trial, text.encode(), _mode_beside(path))
        return trial

    def drop_trials(self) -> None:
        """Delete the texts of commands that editors have left behind which were killed."""
        folders = {(self.root / name).parent for name in self._scan().files}
        for folder in {self.root, *folders}:
            with suppress(OSError):
                for name in os.listdir(folder):  # noqa: PTH208 - names only
                    match = _TRIAL.fullmatch(name)
                    if match and not _runs(int(match["process"])):
                        (folder / name).unlink()

    # ---- the folder ----------------------------------------------------------------------

    def _kind(self, name: str) -> str:
        path = self.root / name
        try:
            return kind_of(path) if path.exists() else "mission"
        except BtMissionError:
            return "mission"

    def _scan(self) -> Listing:
        """Return the only file, or those of the folder."""
        if self.only is not None:
            return Listing({self.only: bool(self._drafts_of(self.only))})
        listing, seen = Listing(), 0
        for folder, folders, names in os.walk(self.root):
            level = len(Path(folder).relative_to(self.root).parts)
            folders[:] = sorted(
                sub for sub in folders if sub[0] not in "._" and level < MOST_LEVELS
            )
            drafts = {match["name"] for match in map(_DRAFT.fullmatch, names) if match}
            yaml = (name for name in {*names, *drafts} if Path(name).suffix in SUFFIXES)
            for name in sorted(name for name in yaml if name[0] != "."):
                path = Path(folder) / name
                inside = str(path.relative_to(self.root))
                if not (_is_text(inside) and inside.isprintable()):
                    written = os.fsencode(inside).decode("utf-8", "backslashreplace")
                    listing.hidden.add(escape_control(written))
                elif not self._is_inside(path):
                    continue
                elif len(listing.files) < MOST_FILES:
                    listing.files[inside] = name in drafts
                else:
                    listing.is_cut = True
            seen += len(names) + len(folders)
            listing.is_cut = listing.is_cut or (seen > MOST_NAMES and bool(folders))
            if listing.is_cut:
                break
        return listing


def _is_text(name: str) -> bool:
    """Return whether a name can be written in UTF-8."""
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True


def _saved_s(path: Path) -> float:
    """Return when a file was written, s since 1970; 0 if it is gone."""
    try:
        return path.lstat().st_mtime
    except OSError:
        return 0.0


def _mode_beside(path: Path) -> int:
    """Return the permissions of a text beside a file: nobody else reads it than may read that."""
    try:
        return path.stat().st_mode & 0o777 | PRIVATE
    except OSError:
        return PRIVATE


def _runs(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return True


def _write(path: Path, content: bytes, mode: int | None = None) -> None:
    """Replace a file: either all of the new text is there afterwards, or the old one.

    Args:
        path: Of a file of the folder, whose target is written; or of one beside it, with a mode.
        content: All of it.
        mode: Its permissions; None keeps those of the file.

    Raises:
        EditError: It cannot be written.
    """
    try:
        write_file(path, content, mode=mode, follows=mode is None)
    except BtMissionError as error:
        reason = str(error).partition(": ")[2]
        raise EditError(f"{path.name}: cannot be written ({reason})") from None
