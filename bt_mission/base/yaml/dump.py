"""Data as the text of a YAML file."""

from __future__ import annotations

from typing import Any

import yaml  # type: ignore[import-untyped]

from bt_mission.base.text import is_shown

WIDTH = 100


class _Dumper(yaml.SafeDumper):  # type: ignore[misc]
    """Quotes texts with characters that cannot be seen, as the reader requires."""


def _text(dumper: Any, text: str) -> Any:
    is_hidden = any(character not in "\n\t" and not is_shown(character) for character in text)
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, '"' if is_hidden else None)


_Dumper.add_representer(str, _text)


def to_yaml(data: Any) -> str:
    """Return data as YAML, in its order."""
    return str(yaml.dump(data, Dumper=_Dumper, sort_keys=False, width=WIDTH, allow_unicode=True))
