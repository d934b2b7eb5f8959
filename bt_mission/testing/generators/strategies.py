"""Hypothesis strategies for worlds and missions; what fails is shrunk to the simplest.

Example::

    @given(scenarios())
    def test_it_never_touches_anything(stage, scenario):
        run = scenario.on(stage)
        run.until_done()
        assert run.check("never collisions > 0")

Worlds and missions are texts of files; a scenario is shown as the file that repeats it. So whatever
fails can be pasted as it is.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hypothesis import strategies as st

from bt_mission.scenarios.faults import PlannedFault
from bt_mission.scenarios.faults.drawing import drawn_faults
from bt_mission.testing.generators.missions import drawn_mission
from bt_mission.testing.generators.scenarios import DrawnScenario, as_text, drawn_scenario
from bt_mission.testing.generators.worlds import drawn_world

__all__ = ["fault_schedules", "missions", "scenarios", "worlds"]


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
    """Texts of valid mission files with all kinds of nodes; they end in bounded time."""
    return as_text(drawn_mission(Drawn(draw)))


@st.composite
def fault_schedules(draw: Any, *names: str) -> tuple[PlannedFault, ...]:
    """Up to five faults, each at its time and with its end.

    Args:
        names: Of the methods of ``stage.faults`` to draw from; by default those of topics, goals
            and feedback.
    """
    return drawn_faults(Drawn(draw), names)


@st.composite
def scenarios(draw: Any, *faults: str) -> DrawnScenario:
    """A world, a mission, a seed and faults.

    Args:
        faults: As the names of :func:`fault_schedules`.
    """
    return drawn_scenario(Drawn(draw), faults)
