"""What drawings show of nodes, in the words of their authors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bt_mission.language.expressions.expression import Value, written_text


def shown_fields(values: Mapping[str, Any]) -> list[str]:
    """Return fields of a message or inputs as a drawing shows them."""
    return [f"{name} {written_text(value)}" for name, value in values.items()]


def shown_limit(timeout: Value | None) -> list[str]:
    """Return a limit in seconds as a drawing shows it."""
    return [] if timeout is None else [f"within {written_text(timeout)} s"]
