"""Scenarios by the thousand, one after another in one process."""

from __future__ import annotations

import gc
from pathlib import Path

from rclpy.logging import LoggingSeverity, set_logger_level

from bt_mission.base.dds.discovery import isolate
from bt_mission.base.dds.middleware import prepare_middleware
from bt_mission.scenarios.run import run_scenario
from bt_mission.scenarios.scenario import Scenario, ScenarioResult


def prepare_process() -> None:
    """Make ready for scenarios a process that does nothing else; call it before all of ROS.

    No process finds this one from now on: it has no port and no shared memory, so that any number
    of them fit beside each other, and one that is killed leaves nothing behind.

    Raises:
        BtMissionError: For an invalid middleware or domain.
    """
    isolate(visible=False)
    prepare_middleware(alone=True)


def silence_logs() -> None:
    """Log nothing but what ends the process.

    Warnings of thousands of failed runs would hide all other output; their reports have the
    reasons.
    """
    set_logger_level("", LoggingSeverity.FATAL)


class ScenarioProcess:
    """Runs any number of scenarios in a process whose memory does not grow with them.

    The nodes, the servers and the physics of a run refer to each other, so Python frees them when
    it looks for such cycles. It does not know of the megabytes of MuJoCo behind a few of its
    objects, and looks too seldom; the heap is in pieces by then. So it is called after each run,
    without the objects of the first one: modules, message types, caches.
    """

    def __init__(self) -> None:
        self._is_frozen = False

    def run(
        self,
        scenario: str | Path | Scenario,
        *,
        seed: int | None = None,
        with_coverage: bool = False,
    ) -> ScenarioResult:
        """Run a scenario as :func:`run_scenario` does, with the same exceptions."""
        try:
            return run_scenario(scenario, seed=seed, with_coverage=with_coverage)
        finally:
            gc.collect()
            if not self._is_frozen:
                self._is_frozen = True
                gc.freeze()
