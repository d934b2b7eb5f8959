"""Data as the text of a YAML file."""

from __future__ import annotations

from typing import Any

import yaml  # type: ignore[import-untyped]

WIDTH = 100


def to_yaml(data: Any) -> str:
    """Return data as YAML, in its order."""
    return str(yaml.safe_dump(data, sort_keys=False, width=WIDTH, allow_unicode=True))
