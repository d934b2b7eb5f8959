"""The entry points of installed packages."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


def entry_points(group: str, name: str | None = None) -> Collection[EntryPoint]:
    """Return the entry points of a group, or those of a name in it.

    This reads the data of every installed package, which takes a tenth of a second.
    """
    from importlib import metadata  # noqa: PLC0415 - no command needs it for a plain mission

    in_group = metadata.entry_points(group=group)
    return in_group if name is None else in_group.select(name=name)
