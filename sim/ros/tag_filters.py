"""Which tags something must have: simulation_interfaces/TagsFilter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

_ALL = 1


def passes(wanted: Any, tags: Sequence[str]) -> bool:
    """Return whether tags pass a TagsFilter: any of those asked for, or all of them."""
    if not wanted.tags:
        return True
    matches = [tag in tags for tag in wanted.tags]
    return all(matches) if wanted.filter_mode == _ALL else any(matches)
