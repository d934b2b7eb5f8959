"""What publishers and recorders are given of a mission that runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bt_mission.behaviours.runtime import Scope
    from bt_mission.executive.executive import Executive
    from bt_mission.goals.ledger import Ledger


@dataclass(frozen=True)
class MissionRun:
    """A mission that runs, for those who describe it.

    `log_listeners` are called with each line of the log and its ROS time, ns; `clock_ns` returns
    the mission's time, ns.
    """

    executive: Executive
    ledger: Ledger
    scope: Scope
    log_listeners: list[Callable[[int, str], None]]
    clock_ns: Callable[[], int]

    @property
    def now_ns(self) -> int:
        """The mission's time, ns."""
        return self.clock_ns()
