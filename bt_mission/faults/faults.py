"""All faults in one class, and the table of them."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from bt_mission.faults.clock import ClockFaults
from bt_mission.faults.errors import ScenarioError
from bt_mission.faults.fault import FaultTarget
from bt_mission.faults.goals import GoalFaults
from bt_mission.faults.maker import PlayedServer
from bt_mission.faults.raising import CodeFaults
from bt_mission.faults.robot import RobotFaults
from bt_mission.faults.servers import ServerFaults
from bt_mission.faults.table import fault_kinds
from bt_mission.faults.topics import TopicFaults
from bt_mission.faults.world import WorldFaults

if TYPE_CHECKING:
    from rclpy.node import Node


class _NoTest:
    """Stands for the test where there is none."""

    scripted: Mapping[str, PlayedServer] = MappingProxyType({})

    def node(self, name: str) -> Node:
        """Refuse: there is no test that has nodes."""
        raise ScenarioError(f"no test is there that could have a node '{name}'")


class Faults(
    TopicFaults,
    GoalFaults,
    ServerFaults,
    CodeFaults,
    RobotFaults,
    WorldFaults,
    ClockFaults,
):
    """Makes faults: in tests actions for ``run.do``, ``run.at`` and ``run.when``.

        blind = stage.faults.drop("scan")
        run.at(5.0, blind)
        run.at(8.0, blind.end)

    Each leaves events in the run's trace, draws what is random from the mission's seed, and
    repeats bit for bit.
    """

    @classmethod
    def alone(cls) -> Faults:
        """Make faults where no test plays a server."""
        return cls(_NoTest())

    def clear(self, run: FaultTarget) -> None:
        """End every fault that goes on; an action, too."""
        for fault in run.faults:
            fault.end_from_outside()


FAULTS = fault_kinds(Faults)
"""Every fault that can be written down, by its name."""
