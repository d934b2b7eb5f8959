"""The signals of requirements on the stage: the true ones of the simulation, and the rest.

The true ones follow from the simulation's state, also later, from a recording.
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import mujoco
import numpy as np
from typing_extensions import override

from bt_mission.language.expressions.values import Plain
from bt_mission.requirements.compiler import Reader
from bt_mission.requirements.language.syntax import SignalValue
from bt_mission.ros.mission_runtime import MissionRuntime
from bt_mission.ros.signals import LiveSignals, SimulationModel
from sim.physics.clearance import Clearance
from sim.physics.history import Reviewer, SimulationState
from sim.robot.robot import SimulatedRobot

_FILE = "model.mjb"
_DISTANCE = struct.Struct("<d")
"""The end of a state, after MuJoCo's qpos and qvel: the length of the path, m."""


class StageSignals(LiveSignals):
    """Signals of a mission on the stage.

    Args:
        runner: The mission.
        robot: The robot in the simulation.
    """

    def __init__(self, runner: MissionRuntime, robot: SimulatedRobot) -> None:
        super().__init__(runner)
        self._robot = robot
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

    @override
    def forget(self) -> None:
        super().forget()
        self._instant += 1

    @override
    def simulation(self) -> SimulationModel:
        model = self._robot.physics.model
        room = np.empty(mujoco.mj_sizeModel(model), np.uint8)
        mujoco.mj_saveModel(model, None, room)
        data = room.tobytes()
        facts = {
            "mujoco": mujoco.__version__,
            "robot": self._robot.prefix,
            "sha256": hashlib.sha256(data).hexdigest(),
        }
        return SimulationModel(data, facts)

    @override
    def truth(self) -> tuple[bytes, Mapping[str, Plain | None]]:
        robot = self._robot
        physics, data = robot.physics, robot.physics.data
        values: dict[str, Plain | None] = {"collisions": robot.collisions}
        if any(physics.props.shown):  # obstacles that are not in the model at the start
            values |= {name: self._truth[name]() for name in ("clearance", "nearest")}
        distance = _DISTANCE.pack(robot.distance_travelled)
        return data.qpos.tobytes() + data.qvel.tobytes() + distance, values

    @override
    def reader(self, signal: SignalValue, /) -> Reader | str:
        known = self._truth.get(signal.name)
        return super().reader(signal) if known is None else known

    @override
    def lower_bound(self, signal: SignalValue, /) -> Callable[[], float | None] | None:
        return self._room if signal.name == "clearance" else None

    @override
    def measured_by(self, signal: SignalValue, /) -> str:
        return "" if signal.name in self._truth else super().measured_by(signal)

    def _once(self, read: Callable[[], Any]) -> Callable[[], Any]:
        """Return a reader that reads a value once at each instant, however often it is called."""
        of, value = -1, None

        def known() -> Any:
            nonlocal of, value
            if of != self._instant:
                of, value = self._instant, read()
            return value

        return known


class RecordedTruth:
    """The true signals of a simulation, from its model and a recorded state.

    Args:
        model: The model from :meth:`StageSignals.simulation`.

    Raises:
        ValueError: It cannot be read, with the reason.
    """

    def __init__(self, model: SimulationModel) -> None:
        made_with, here = str(model.facts.get("mujoco", "?")), mujoco.__version__
        if made_with != here:
            raise ValueError(f"it was simulated by MuJoCo {made_with}, but {here} is installed")
        if hashlib.sha256(model.data).hexdigest() != model.facts.get("sha256"):
            raise ValueError("the model of the simulation is damaged")
        self._model = mujoco.MjModel.from_binary_path(_FILE, {_FILE: model.data})
        self._reviewer = Reviewer(self._model, str(model.facts.get("robot", "")))
        self._state = SimulationState(0, b"", b"", ())
        self.distance = 0.0
        """Length of the path, m."""

    def show(self, state: bytes) -> None:
        """Use this state from now on. Raises ValueError if it is not of the model."""
        split, end = 8 * self._model.nq, 8 * (self._model.nq + self._model.nv)
        if len(state) != end + _DISTANCE.size:
            raise ValueError("a state is not of the recorded model")
        self._state = SimulationState(0, state[:split], state[split:end], ())
        (self.distance,) = _DISTANCE.unpack_from(state, end)
        self.__dict__.pop("clearance", None)

    @property
    def pose(self) -> tuple[float, float, float]:
        """True pose in the map: x m, y m, yaw rad."""
        return self._reviewer.pose(self._state)

    @property
    def velocity(self) -> tuple[float, float]:
        """True velocity: ahead m/s, left turn rad/s."""
        return self._reviewer.velocity(self._state)

    @cached_property
    def clearance(self) -> Clearance:
        """The clearance, and the nearest obstacle."""
        return self._reviewer.clearance(self._state)


OF_STATE: Mapping[str, Callable[[RecordedTruth], Plain]] = {
    "x": lambda truth: truth.pose[0],
    "y": lambda truth: truth.pose[1],
    "yaw": lambda truth: truth.pose[2],
    "speed": lambda truth: truth.velocity[0],
    "turn_rate": lambda truth: truth.velocity[1],
    "distance": lambda truth: truth.distance,
    "clearance": lambda truth: float(truth.clearance.distance),
    "nearest": lambda truth: truth.clearance.obstacle or "",
}
"""True signals that follow from a state."""
