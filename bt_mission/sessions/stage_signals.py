"""The signals of requirements on the stage: what is true in the simulation, and the rest."""

from __future__ import annotations

from typing import Any

from typing_extensions import override

from bt_mission.language.requirements.syntax import SignalValue
from bt_mission.requirements.compiler import Reader
from bt_mission.ros.signals import LiveSignals, SignalsRun
from sim.robot.robot import SimulatedRobot


class StageSignals(LiveSignals):
    """Signals of a mission on the stage.

    Args:
        runner: Whose mission it is.
        robot: What moves in the simulation.
    """

    def __init__(self, runner: SignalsRun, robot: SimulatedRobot) -> None:
        super().__init__(runner)
        self._robot = robot
        self._clearance: Any = None

    @override
    def forget(self) -> None:
        super().forget()
        self._clearance = None

    @override
    def reader(self, signal: SignalValue, /) -> Reader | str:
        robot = self._robot
        truth: dict[str, Reader] = {
            "x": lambda: robot.pose[0],
            "y": lambda: robot.pose[1],
            "yaw": lambda: robot.pose[2],
            "clearance": lambda: float(self._measured().distance),
            "nearest": lambda: self._measured().obstacle or "",
            "collisions": lambda: robot.collisions,
            "speed": lambda: robot.velocity[0],
            "turn_rate": lambda: robot.velocity[1],
            "distance": lambda: robot.distance_travelled,
        }
        return truth[signal.name] if signal.name in truth else super().reader(signal)

    def _measured(self) -> Any:
        """Return the clearance at this instant, measured once."""
        if self._clearance is None:
            self._clearance = self._robot.clearance()
        return self._clearance
