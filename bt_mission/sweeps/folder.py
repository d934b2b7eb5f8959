"""Paths in a folder of results, which may come from others: no link is followed out of it."""

from __future__ import annotations

from pathlib import Path, PurePosixPath

from bt_mission.core.errors import BtMissionError


class StoreError(BtMissionError):
    """A folder of results that cannot be used; it says what to do."""


def within(folder: Path, name: str) -> Path:
    """Return a path in a folder.

    Args:
        folder: As the user has named it; it may be a link itself.
        name: From there, with ``/`` between folders.

    Raises:
        StoreError: For a name that leads out of the folder, or through a symbolic link.
    """
    parts = PurePosixPath(name).parts
    if not parts or parts[0] == "/" or ".." in parts:
        raise StoreError(f"{folder}: '{name}' leads out of the folder")
    path = folder
    for part in parts:
        path = path / part
        if path.is_symlink():
            raise StoreError(
                f"{path}: a symbolic link; those in a folder of results are not followed"
            )
    return path
