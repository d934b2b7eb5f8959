"""YAML files with places: plain data, and the line and column of each part.

`read` takes a file, `read_text` a text; both return a `Document` or raise `InputError`.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bt_mission.base.diagnostics import Diagnostic, InputError, Severity, diagnostic_at
from bt_mission.base.files import open_file
from bt_mission.base.yaml.composer import Place, compose, split_lines

MAX_BYTES = 1_000_000
"""The largest file that is read. A mission of 10,000 nodes takes about 0.9 of it."""

Key = str | int


@dataclass(frozen=True)
class Document:
    """A YAML file as plain data (dict, list, str, int, float, bool, None) and its places."""

    file: str
    data: Any
    place: Place
    lines: tuple[str, ...]
    included: Mapping[str, Document] = field(default_factory=dict, repr=False, compare=False)
    """Files that it includes and that were read with it, by their entries."""

    @property
    def text(self) -> str:
        """The file as a text, with a line feed at its end."""
        return "\n".join(self.lines).rstrip("\n") + "\n"

    @property
    def is_xml(self) -> bool:
        """Whether the file is XML, which other readers turn into such data."""
        return self.text.lstrip().startswith("<")

    def under(self, key: str) -> Document:
        """Return the part under a key as a document, with its places in this file."""
        return Document(self.file, self.data[key], self.find((key,)), self.lines)

    def find(self, path: Sequence[Key]) -> Place:
        """Return the place of the value at `path`, or of the deepest part of it that exists."""
        return self._deepest(path)[0]

    def has(self, *path: Key) -> bool:
        """Return whether there is a value at this path."""
        return self._deepest(path)[1] == len(path)

    def _deepest(self, path: Sequence[Key]) -> tuple[Place, int]:
        place = self.place
        for depth, key in enumerate(path):
            inner = place.child(key)
            if inner is None:
                return place, depth
            place = inner
        return place, len(path)

    def position(self, path: Sequence[Key], *, key: bool = False) -> tuple[int, int]:
        """Return line and column (from 1) of the value at `path`, or of its key."""
        if key and path and isinstance(path[-1], str):
            parent = self.find(path[:-1])
            return (parent.keys or {}).get(path[-1], (parent.line, parent.column))
        place = self.find(path)
        return place.line, place.column

    def diagnostic(
        self,
        code: str,
        path: Sequence[Key],
        message: str,
        hint: str | None = None,
        *,
        key: bool = False,
        severity: Severity = "error",
        offset: int | None = None,
    ) -> Diagnostic:
        """Return a diagnostic at the value at `path`, or at its key.

        `offset` (from 0) moves the caret into a key, or into a text value whose characters are the
        same in the file: on one line, without escapes.
        """
        line, column = self.position(path, key=key)
        if offset is not None:
            column += offset if key else self._shift(self.find(path), offset)
        return diagnostic_at(code, (line, column), self.file, self.lines, message, hint, severity)

    def _shift(self, place: Place, offset: int) -> int:
        if place.text is None:
            return 0
        line = self.lines[place.line - 1] if place.line <= len(self.lines) else ""
        start = place.column - 1
        quote = 1 if line[start : start + 1] in ("'", '"') else 0
        as_written = line[start + quote : start + quote + len(place.text)] == place.text
        return offset + quote if as_written and offset <= len(place.text) else 0


def read_text(text: str, file: str = "<text>") -> Document:
    """Read YAML from a text. Raises InputError."""
    refuse_large(text, file)
    data, place = compose(text, file)
    return Document(file, data, place, split_lines(text))


def refuse_large(text: str, file: str) -> None:
    """Raise InputError for a text that is larger than any file that is read."""
    _refuse_size(len(text.encode("utf-8", "replace")), file)


def _refuse_size(size: int, file: str) -> None:
    if size > MAX_BYTES:
        message = f"the file is too large: {size:,} bytes, the limit is {MAX_BYTES:,}"
        raise InputError([Diagnostic("BT-103", message, file)])


def read(path: str | Path) -> Document:
    """Read a YAML file. Raises InputError; a file that is too large is refused unread."""
    return read_text(read_source(path), str(path))


def read_source(path: str | Path) -> str:
    """Return the text of a file. Raises InputError; a file that is too large is refused unread."""
    return text_of(contents(path), str(path))


def text_of(contents: bytes, file: str) -> str:
    """Return the contents of a file as text. Raises InputError with the place of the error."""
    try:
        return contents.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        *before, last = contents[: error.start].split(b"\n")
        column = len(last.decode("utf-8", "replace")) + 1
        message = f"expected text in UTF-8, got the byte 0x{contents[error.start]:02x}"
        raise InputError([Diagnostic("BT-102", message, file, len(before) + 1, column)]) from error


def contents(path: str | Path, *, follows: bool = True) -> bytes:
    """Return all of a file that is not too large. Raises InputError; see `open_file`."""
    file = str(path)
    try:
        with open_file(path, follows=follows) as stream:
            _refuse_size(os.fstat(stream.fileno()).st_size, file)
            whole = stream.read(MAX_BYTES + 1)
    except (FileNotFoundError, NotADirectoryError, ValueError) as error:
        raise InputError([Diagnostic("BT-101", "no such file", file)]) from error
    except OSError as error:
        reason = error.strerror or str(error)
        if error.errno == errno.ELOOP:
            reason = "no such file"
        elif not reason.startswith("expected"):
            reason = f"cannot read the file: {reason}"
        raise InputError([Diagnostic("BT-101", reason, file)]) from error
    _refuse_size(len(whole), file)
    return whole
