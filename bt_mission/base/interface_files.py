"""The files of ROS interfaces that packages install. ROS itself is not needed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from bt_mission.base.files import prefixes


def share_folders() -> list[Path]:
    """Return the folders of interface packages, in order of precedence.

    The last are replacements of real packages (interfaces/wheel).
    """
    shares = [prefix / "share" for prefix in prefixes()]
    return [*shares, *(share / "bt_mission/ros/share" for share in shares)]


def file_text(type_name: str, folders: Sequence[Path]) -> str | None:
    """Return the text of a type's file, such as ``std_srvs/srv/Trigger``, if it exists."""
    package, folder, name = type_name.split("/")
    for share in folders:
        path = share / package / folder / f"{name}.{folder}"
        if path.is_file():
            return path.read_text(encoding="utf-8")
    return None
