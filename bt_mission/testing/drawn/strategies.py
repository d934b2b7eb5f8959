"""Hypothesis strategies for worlds and missions; what fails is shrunk to the simplest.

    @given(worlds(), missions())
    def test_it_never_touches_anything(world, mission): ...

Each value is the text of a file, so a failing one can be pasted into a test or a file as it is.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import yaml  # type: ignore[import-untyped]
from hypothesis import strategies as st

from bt_mission.testing.drawn.missions import drawn_mission
from bt_mission.testing.drawn.worlds import drawn_world


class Drawn:
    """Draws by hypothesis."""

    def __init__(self, draw: Callable[[st.SearchStrategy[int]], int]) -> None:
        self._draw = draw

    def whole(self, low: int, high: int) -> int:
        """A number from ``low`` to ``high``, both included."""
        return self._draw(st.integers(low, high))


@st.composite
def worlds(draw: Any) -> str:
    """Texts of world files: walls around, and up to six obstacles, some of which move."""
    return as_text(drawn_world(Drawn(draw)))


@st.composite
def missions(draw: Any) -> str:
    """Texts of mission files that are sound, of all kinds of nodes; they end in bounded time."""
    return as_text(drawn_mission(Drawn(draw)))


def as_text(data: dict[str, Any]) -> str:
    """The file of this data."""
    return str(yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=100))
