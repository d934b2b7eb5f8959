"""Missions and worlds that another file names: located beside it, and checked with their places."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from bt_mission.base.diagnostics import Diagnostic, InputError, did_you_mean, quoted
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import is_file, kind_of, look_for, names
from bt_mission.base.yaml.document import Document
from bt_mission.language.inputs import SET_OPTION
from bt_mission.language.mission import Mission
from bt_mission.language.permissions import ANYTHING, Permissions
from bt_mission.sessions.check import examine
from bt_mission.sessions.load import document_of
from sim.world.loader import load_world, world_in
from sim.world.world import World


class NamedFiles:
    """Locates and reads the files that a file names.

    Args:
        document: The file.
        diagnostics: Receives every error and warning, each with its place.
        permissions: The files that may be read.
    """

    def __init__(
        self, document: Document, diagnostics: list[Diagnostic], permissions: Permissions = ANYTHING
    ) -> None:
        self._document = document
        self._diagnostics = diagnostics
        self._permissions = permissions

    def text_of(self, written: Any, path: Sequence[str]) -> Document | None:
        """Read the text of a mission; None if it has an error.

        Args:
            written: Its name, its path, or its whole text.
            path: The place of that.
        """
        if isinstance(written, dict):
            document = self._document
            for key in path:
                document = document.under(key)
            return document
        file = self._mission_file(written, path)
        try:
            return None if file is None else document_of(file)
        except InputError as error:
            self._diagnostics += error.diagnostics
            return None

    def mission(
        self,
        text: Document | None,
        locate: Callable[[str, Diagnostic], Diagnostic],
        **changes: Any,
    ) -> Mission | None:
        """Check a mission; None if it has an error.

        Args:
            text: The text, from `text_of`.
            locate: Gets the name of an input and an error of its value; returns the error with the
                place of the value.
            changes: See `examine`.
        """
        if text is None:
            return None
        mission, diagnostics = examine(text, **changes)
        self._diagnostics += [
            locate(diagnostic.source.partition("=")[0], diagnostic)
            if diagnostic.file == SET_OPTION
            else diagnostic
            for diagnostic in diagnostics
        ]
        return mission

    def world(self, written: Any, path: Sequence[str]) -> World | None:
        """Read a world; None if it has an error."""
        document = self._document
        try:
            if isinstance(written, dict):
                return world_in(document, tuple(path))
            file = self.beside(written) or look_for("worlds", written, document.file)
            if file is not None and not self._permissions.allows(file, "worlds"):
                self._refuse(written, path)
                return None
            return load_world(file or written, near=document.file)
        except InputError as error:
            first = error.diagnostics[0]
            if isinstance(written, dict) or first.line:
                self._diagnostics += error.diagnostics
            else:  # there is no such world
                message = f"{quoted(written)}: {first.message}"
                self._diagnostics.append(document.diagnostic(first.code, path, message, first.hint))
        except BtMissionError as error:
            self._diagnostics.append(document.diagnostic(error.code, path, str(error)))
        return None

    def beside(self, name: str) -> Path | None:
        """Return the file at a path relative to this file, whatever the working folder."""
        path = Path(self._document.file).parent / name
        return path if path.suffix and is_file(path) else None

    def _refuse(self, name: str, path: Sequence[str]) -> None:
        message = f"{quoted(name)} is outside of the folder, and is not read"
        self._diagnostics.append(self._document.diagnostic("BT-112", path, message))

    def _mission_file(self, name: str, path: Sequence[str]) -> Path | None:
        file = self.beside(name) or look_for("missions", name, near=self._document.file)
        if file is None:
            message = f"no such mission: {quoted(name)}, beside this file or among the shipped ones"
            hint = did_you_mean(Path(name).stem, names("missions"))
            self._diagnostics.append(self._document.diagnostic("BT-110", path, message, hint))
        elif not self._permissions.allows(file, "missions"):
            self._refuse(name, path)
            return None
        elif (kind := kind_of(file)) != "mission":
            message = f"{quoted(name)} is a {kind}; expected a mission"
            self._diagnostics.append(self._document.diagnostic("BT-111", path, message))
            return None
        return file
