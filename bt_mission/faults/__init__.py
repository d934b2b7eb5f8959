"""What can be broken on purpose: faults of the robot, its servers, its topics and its world.

- ``fault``: :class:`Fault`, an action on a run that goes on for a while
- ``maker``, ``parameters``: how a fault is declared, and what it makes of what passes
- ``table``: every fault with what it takes, for files, texts and documentation
- ``topics``, ``corruptions``: messages on their way between nodes
- ``goals``: what passes between an action server and its clients
- ``servers``: servers that abort, die or fail
- ``clock``: a clock that is set, or stands still
- ``raising``: exceptions in code
- ``robot``, ``world``: sensors, wheels, pushes; obstacles that appear, move and vanish
"""

from __future__ import annotations

from bt_mission.faults.clock import ClockFaults
from bt_mission.faults.fault import Fault, FaultInstance, FaultTarget
from bt_mission.faults.goals import GoalFaults
from bt_mission.faults.raising import CodeFaults
from bt_mission.faults.robot import RobotFaults
from bt_mission.faults.servers import ServerFaults
from bt_mission.faults.table import fault_kinds
from bt_mission.faults.topics import TopicFaults
from bt_mission.faults.world import WorldFaults

__all__ = ["FAULTS", "Fault", "FaultInstance", "Faults"]


class Faults(
    TopicFaults,
    GoalFaults,
    ServerFaults,
    CodeFaults,
    RobotFaults,
    WorldFaults,
    ClockFaults,
):
    """Makes faults: actions for ``run.do``, ``run.at`` and ``run.when``.

        blind = stage.faults.drop("scan")
        run.at(5.0, blind)
        run.at(8.0, blind.end)

    Each leaves events in the run's trace, draws what is random from the mission's seed, and
    repeats bit for bit.
    """

    def clear(self, run: FaultTarget) -> None:
        """End every fault that goes on; an action, too."""
        for fault in run.faults:
            fault.end()


FAULTS = fault_kinds(Faults)
"""Every fault that can be written down, by its name."""
