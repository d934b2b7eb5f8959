"""What a mission may bring in beside its own text: files that it includes, and Python code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from bt_mission.base import files

PythonUse = Literal["import", "name", "refuse"]
"""What becomes of Python leaves: they are imported and checked, only named, or refused."""


@dataclass(frozen=True)
class Permissions:
    """The code and files that a mission may use.

    Attributes:
        folders: The folders from which files may come, links followed; None is any folder.
        includes: May it include files?
        python: What becomes of Python leaves.
        constructs: Construct the leaves that are imported, to find what their constructors raise. A
            run does so later; a server, before a mission ends for another one.
        hint: What to do about leaves or files that are refused, or leaves that are only named.
        texts: Those of the files that it may include, by name; None reads them from the disk.
    """

    folders: tuple[Path, ...] | None = None
    includes: bool = True
    python: PythonUse = "import"
    constructs: bool = False
    hint: str | None = None
    texts: Mapping[str, str] | None = None

    def allows(self, path: Path, kind: files.Kind) -> bool:
        """Return whether a file may be used.

        Beside the folders, missions that are shipped may be included, and worlds and robots be
        named that are known on this machine.
        """
        if self.folders is None:
            return True
        known = files.folders(kind)
        if kind == "missions":
            known = known[1:]  # without the one of the working folder, which may not be served
        else:
            known += [folder.parent / kind for folder in self.folders]
        return is_within(path, (*self.folders, *known))


ANYTHING = Permissions()
"""What a person's own missions may: everything."""


def is_within(path: Path, folders: tuple[Path, ...]) -> bool:
    """Return whether a file lies in one of the folders or below, links followed."""
    try:
        real = path.resolve()
        return any(real.is_relative_to(folder.resolve()) for folder in folders)
    except (OSError, RuntimeError, ValueError):  # a ring of links, a name that is too long
        return False
