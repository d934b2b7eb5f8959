"""What faults of goals are tried with: a turn of 90 deg, which takes 1.9 s."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest


@pytest.fixture
def turn(stage: Any) -> Callable[..., Any]:
    """Runs of one turn; the mission waits a second where that fails.

    The modifiers of the turn are arguments: ``turn(timeout=1)``.
    """

    def make(**modifiers: Any) -> Any:
        lines = [f"      {name}: {value}" for name, value in modifiers.items()]
        return stage.run(
            "\n".join(
                [
                    "mission: turns",
                    "world: empty_arena",
                    "tree:",
                    "  fallback:",
                    "    - turn: {angle: 90}",
                    *lines,
                    "    - wait: 1",
                    "",
                ]
            )
        )

    return make
