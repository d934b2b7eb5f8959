"""Looking back at a run: poses, room and contacts at instants that were recorded.

    states = []
    ...                                       # while it runs, as often as wanted
    states.append(simulation.record())
    ...                                       # afterwards
    review = simulation.review()
    assert all(review.clearance(state).distance > 0.05 for state in states)

A record costs a run little. All computing is done later, on a separate model and state.
"""

from __future__ import annotations

import copy
import math
import struct
from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from sim.physics.clearance import Clearance, Point, robot_gauge
from sim.physics.contacts import Contacts
from sim.physics.names import BASE
from sim.physics.prop_bodies import bodies_of
from sim.world.shapes import Obstacle


@dataclass(frozen=True, slots=True)
class SimulationState:
    """Poses and velocities of everything at one instant.

    `qpos` and `qvel` are MuJoCo's, as bytes, so that states can be compared; `props` are the shown
    props. It can be read with the model that it was recorded from.
    """

    time_ns: int
    qpos: bytes
    qvel: bytes
    props: tuple[Obstacle | None, ...]


class ModelCopy:
    """A separate model and state in which recorded states of a simulation are shown."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self.model = copy.copy(model)
        self.data = mujoco.MjData(self.model)
        self.names, self._bodies = bodies_of(self.model)

    def show(self, state: SimulationState) -> None:
        """Restore all poses and velocities."""
        self._bodies.match(state.props)
        self.data.qpos[:] = np.frombuffer(state.qpos)
        self.data.qvel[:] = np.frombuffer(state.qvel)
        mujoco.mj_kinematics(self.model, self.data)


class Reviewer:
    """Evaluates recorded states of a simulation for one robot (`prefix`).

    States may come in any order, also while the simulation runs.
    """

    def __init__(self, model: mujoco.MjModel, prefix: str = "") -> None:
        self._copy = own = ModelCopy(model)
        self._gauge = robot_gauge(own.model, own.names, prefix)
        self._contacts = Contacts(own.model, own.names, prefix)
        joint = model.joint(prefix + BASE)
        self._q, self._v = int(joint.qposadr[0]), int(joint.dofadr[0])
        self._shown: SimulationState | None = None

    def pose(self, state: SimulationState) -> tuple[float, float, float]:
        """Return the true pose of `base_footprint` in the map: x m, y m, yaw rad."""
        return pose_of(np.frombuffer(state.qpos)[self._q :])

    def velocity(self, state: SimulationState) -> tuple[float, float]:
        """Return the true velocity of the base: ahead m/s, left turn rad/s."""
        return velocity_of(
            np.frombuffer(state.qpos)[self._q :], np.frombuffer(state.qvel)[self._v :]
        )

    def clearance(self, state: SimulationState, within: float = math.inf) -> Clearance:
        """Return the clearance of the robot; obstacles at `within` m or more are ignored."""
        self._show(state)
        return self._gauge.measure(self._copy.data, within)

    def contacts(self, state: SimulationState) -> dict[str, Point]:
        """Return the obstacles that the robot touches, each with a point in the map (m)."""
        self._show(state)
        model, data = self._copy.model, self._copy.data
        mujoco.mj_comPos(model, data)
        mujoco.mj_collision(model, data)
        places = data.contact.pos
        return {
            name: (float(places[index, 0]), float(places[index, 1]), float(places[index, 2]))
            for name, index in self._contacts.touched(data).items()
        }

    def _show(self, state: SimulationState) -> None:
        if state is not self._shown:
            self._copy.show(state)
            self._shown = state


_FREE_POSE, _FREE_VELOCITY = struct.Struct("7d"), struct.Struct("6d")
"""Coordinates of a free joint; read in this way, they take half the time of an array's slice."""


def pose_of(qpos: npt.NDArray[np.float64]) -> tuple[float, float, float]:
    """Return the pose of a robot whose coordinates these are: x m, y m, yaw rad."""
    x, y, _, qw, qx, qy, qz = _FREE_POSE.unpack_from(qpos.data)
    return x, y, math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))


def velocity_of(
    qpos: npt.NDArray[np.float64], qvel: npt.NDArray[np.float64]
) -> tuple[float, float]:
    """Return the velocity of a robot with these coordinates: ahead m/s, left turn rad/s."""
    _, _, _, qw, qx, qy, qz = _FREE_POSE.unpack_from(qpos.data)
    vx, vy, _, _, _, turn = _FREE_VELOCITY.unpack_from(qvel.data)
    # Along and across the heading, still multiplied by the length of (cos yaw, sin yaw).
    ahead, across = 1 - 2 * (qy * qy + qz * qz), 2 * (qw * qz + qx * qy)
    return (vx * ahead + vy * across) / (math.hypot(ahead, across) or 1.0), turn
