"""What carries many concrete scenarios out: in this process, or in many."""

from __future__ import annotations

from collections.abc import AsyncGenerator, Iterable
from typing import Protocol

from bt_mission.sweeps.concrete import ConcreteScenario
from bt_mission.sweeps.row import ScenarioRow
from bt_mission.sweeps.work import ScenarioWorker


class ScenarioRunner(Protocol):
    """Carries concrete scenarios of one bundle out."""

    def rows(self, scenarios: Iterable[ConcreteScenario]) -> AsyncGenerator[ScenarioRow, None]:
        """Yield the row of each scenario, in the order in which they end."""


class SerialRunner:
    """Carries one scenario after another out in this process.

    Args:
        worker: Of the bundle.
    """

    def __init__(self, worker: ScenarioWorker) -> None:
        self._worker = worker

    async def rows(
        self, scenarios: Iterable[ConcreteScenario]
    ) -> AsyncGenerator[ScenarioRow, None]:
        """Yield the row of each scenario, in their order."""
        for one in scenarios:
            yield self._worker.carry_out(one)
