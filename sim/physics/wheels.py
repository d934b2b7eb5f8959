"""What holds a robot's wheels back: gears without power, brakes, and how little they grip."""

from __future__ import annotations

import mujoco
import numpy as np

from sim.faults import WheelFaults
from sim.physics.grip import Grip
from sim.physics.names import BASE, GEAR_FRICTION, WHEELS

BLOCKED_FRICTION = 5.0
"""N m: some twenty times what floor and motor can turn a wheel with."""

BLOCKED_IMPEDANCE = 0.9999
"""MuJoCo's largest: a blocked wheel creeps at 0.0001 rad/s against its motor; with what its joints
have else, 800 times as fast."""


class Wheels:
    """The friction of both wheels of one robot, in their bearings and on the floor."""

    def __init__(self, model: mujoco.MjModel, grip: Grip, prefix: str) -> None:
        first = int(model.joint(prefix + BASE).dofadr[0]) + 6
        self._friction = model.dof_frictionloss[first : first + 2]
        self._impedance = model.dof_solimp[first : first + 2, :2]
        self._usual = self._impedance.copy()
        self._grip = grip
        self._geoms = [model.geom(prefix + name).id for name in WHEELS]
        self._powered = True
        self._faults = WheelFaults()

    def power(self, *, on: bool) -> None:
        """Let the motors turn them, or their gears hold them back."""
        self._powered = on
        self._set()

    def suffer(self, faults: WheelFaults) -> None:
        """Let them have these faults from now on."""
        self._faults = faults
        self._set()
        for geom, grip in zip(self._geoms, (faults.left_grip, faults.right_grip), strict=True):
            self._grip.limit(geom, grip)

    def _set(self) -> None:
        rest = 0.0 if self._powered else GEAR_FRICTION
        blocked = self._faults.left_blocked, self._faults.right_blocked
        self._friction[:] = [BLOCKED_FRICTION if held else rest for held in blocked]
        self._impedance[:] = self._usual
        self._impedance[np.array(blocked)] = BLOCKED_IMPEDANCE
