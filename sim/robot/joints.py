"""The joints of arm and gripper: position servos that follow commands within their limits.

A command is reached at constant speed within one period of control, or at the joint's highest
speed. Without further commands a joint stays where it was sent to, also while the motors of the
wheels have no power.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from bt_mission.base.diagnostics import listed
from bt_mission.robots.model import RobotModel
from sim.physics.names import MODEL_PREFIX, STEP_NS
from sim.physics.physics import Physics


class JointServos:
    """The setpoints of the actuators of a robot's joints."""

    def __init__(self, physics: Physics, robot: RobotModel, prefix: str) -> None:
        model, data = physics.model, physics.data
        limits = robot.moved_joints
        self.names = tuple(limits)
        """The names of the joints, in `joint_states` and in commands."""
        joints = [model.joint(prefix + MODEL_PREFIX + name).id for name in limits]
        by_joint = {int(joint): each for each, joint in enumerate(model.actuator_trnid[:, 0])}
        self._model, self._data = model, data
        self._actuators = np.array([by_joint[joint] for joint in joints], dtype=np.intp)
        self._angles = model.jnt_qposadr[joints]
        self._speeds = model.jnt_dofadr[joints]
        self._forces = model.actuator_forcerange[self._actuators].copy()
        self._force_limits = model.actuator_forcelimited[self._actuators].copy()
        self._least = np.array([each.min for each in limits.values()])
        self._most = np.array([each.max for each in limits.values()])
        self._fastest = np.array([each.max_velocity for each in limits.values()]) * STEP_NS / 1e9
        self._start = np.array([each.start for each in limits.values()])
        self._period_steps = max(1.0, 1e9 / STEP_NS / robot.control_rate)
        self._target = self._start.copy()
        self._step = self._fastest.copy()
        self._at_target = True
        data.qpos[self._angles] = data.ctrl[self._actuators] = self._start

    def restart(self) -> None:
        """Be as at the start, where the physics has been put."""
        self._target[:] = self._start
        self._at_target = True
        self._limit_forces(np.zeros(len(self.names)))

    def command(
        self, names: Sequence[str], positions: Sequence[float], efforts: Sequence[float] = ()
    ) -> None:
        """Send joints to positions, rad or m, with at most a force each; 0 is that of the model.

        Raises ValueError for an unknown joint, or a number that is not finite; nothing then moves.
        """
        unknown = sorted(set(names) - set(self.names))
        if unknown:
            raise ValueError(f"unknown joint {unknown[0][:60]!r} (known: {listed(self.names)})")
        if len(positions) != len(names) or len(efforts) not in (0, len(names)):
            raise ValueError(f"expected {len(names)} positions, and as many efforts or none")
        if not all(map(math.isfinite, (*positions, *efforts))):
            raise ValueError("expected finite positions and efforts")
        index = [self.names.index(name) for name in names]
        self._target[index] = np.clip(positions, self._least[index], self._most[index])
        way = np.abs(self._target - self._data.ctrl[self._actuators])
        self._step = np.minimum(self._fastest, np.maximum(way / self._period_steps, 1e-9))
        self._at_target = False
        if efforts:
            forces = np.zeros(len(self.names))
            forces[index] = efforts
            self._limit_forces(forces)

    def step(self) -> None:
        """Move the setpoints, before a step of the physics."""
        if self._at_target:
            return
        now = self._data.ctrl[self._actuators]
        left = self._target - now
        if (np.abs(left) <= self._step).all():
            self._data.ctrl[self._actuators] = self._target
            self._at_target = True
        else:
            self._data.ctrl[self._actuators] = now + np.clip(left, -self._step, self._step)

    @property
    def readings(self) -> Mapping[str, tuple[float, ...]]:
        """Positions (rad or m), velocities and forces, each in the order of the names."""
        data = self._data
        return {
            "position": tuple(data.qpos[self._angles].tolist()),
            "velocity": tuple(data.qvel[self._speeds].tolist()),
            "effort": tuple(data.actuator_force[self._actuators].tolist()),
        }

    def _limit_forces(self, forces: np.ndarray) -> None:
        """Limit the force of each actuator, where it is above 0; the model's limit stays below."""
        limited = self._force_limits.astype(bool)
        most = np.where(limited, self._forces[:, 1], np.inf)
        chosen = np.where(forces > 0, np.minimum(forces, most), most)
        is_limited = np.isfinite(chosen)
        self._model.actuator_forcelimited[self._actuators] = is_limited
        self._model.actuator_forcerange[self._actuators, 0] = np.where(is_limited, -chosen, 0.0)
        self._model.actuator_forcerange[self._actuators, 1] = np.where(is_limited, chosen, 0.0)
