"""The signals of requirements on the stage: what is true in the simulation, and the rest."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from typing_extensions import override

from bt_mission.language.requirements.syntax import SignalValue
from bt_mission.requirements.comparisons import Reader
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
        self._instant = 0
        self._measured = self._once(robot.clearance)
        self._room = self._once(robot.clearance_at_least)
        self._velocity = self._once(lambda: robot.velocity)
        self._pose = self._once(lambda: robot.pose)
        self._truth: dict[str, Reader] = {
            "x": lambda: self._pose()[0],
            "y": lambda: self._pose()[1],
            "yaw": lambda: self._pose()[2],
            "clearance": lambda: float(self._measured().distance),
            "nearest": lambda: self._measured().obstacle or "",
            "collisions": lambda: robot.collisions,
            "speed": lambda: self._velocity()[0],
            "turn_rate": lambda: self._velocity()[1],
            "distance": lambda: robot.distance_travelled,
        }
        self._truth = {name: self._once(read) for name, read in self._truth.items()}

    @override
    def forget(self) -> None:
        super().forget()
        self._instant += 1

    @override
    def reader(self, signal: SignalValue, /) -> Reader | str:
        known = self._truth.get(signal.name)
        return super().reader(signal) if known is None else known

    @override
    def at_least(self, signal: SignalValue, /) -> Callable[[], float | None] | None:
        return self._room if signal.name == "clearance" else None

    @override
    def measured_by(self, signal: SignalValue, /) -> str:
        return "" if signal.name in self._truth else super().measured_by(signal)

    def _once(self, read: Callable[[], Any]) -> Callable[[], Any]:
        """Return what reads a value once at each instant, however often it is asked."""
        of, value = -1, None

        def known() -> Any:
            nonlocal of, value
            if of != self._instant:
                of, value = self._instant, read()
            return value

        return known
