"""The friction of wheels: gears without power, brakes, and the grip on the floor."""

from __future__ import annotations

import mujoco
import numpy as np

from sim.faults import WheelFaults
from sim.physics.names import GEAR_FRICTION, GRIP, WHEELS
from sim.world.world import World

BLOCKED_FRICTION = 5.0
"""N m: some twenty times what floor and motor can turn a wheel with."""

BLOCKED_IMPEDANCE = 0.9999
"""MuJoCo's largest: a blocked wheel creeps at 0.0001 rad/s against its motor; with the value of the
other joints, 800 times as fast.
"""

LEAST = 0.001
"""Without any friction at all MuJoCo's contacts become unstable, and throw the robot."""


class Grip:
    """Sets the friction of every wheel by its place on the floor, and by its limit."""

    def __init__(self, model: mujoco.MjModel, world: World) -> None:
        names = [(model.geom(geom).name, geom) for geom in range(model.ngeom)]
        self._wheels = [geom for name, geom in names if name.endswith(WHEELS)]
        self._model = model
        self._friction = model.geom_friction
        self._limits = dict.fromkeys(self._wheels, GRIP[0])
        self._places = np.array([(patch.x, patch.y) for patch in world.slippery])
        self._radii = np.array([patch.radius for patch in world.slippery])
        self._coefficients = np.array([max(LEAST, patch.friction) for patch in world.slippery])

    def limit(self, wheel: int, coefficient: float) -> None:
        """Limit the grip of a wheel, by its geom's number, everywhere."""
        self._limits[wheel] = max(LEAST, min(coefficient, GRIP[0]))
        self._friction[wheel, 0] = self._limits[wheel]
        # The larger friction of two bodies counts, unless one takes precedence.
        self._model.geom_priority[wheel] = coefficient < GRIP[0]

    def at(self, x: float, y: float) -> float:
        """Return the friction of the floor at a place of the map (m), for a base without wheels."""
        inside = np.hypot(self._places[:, 0] - x, self._places[:, 1] - y) < self._radii
        return float(self._coefficients[inside].min()) if inside.any() else GRIP[0]

    def apply(self, data: mujoco.MjData) -> None:
        """Set it for the next step, by the places at the beginning of the one before."""
        for wheel in self._wheels:
            offsets = self._places - data.geom_xpos[wheel, :2]
            inside = np.hypot(offsets[:, 0], offsets[:, 1]) < self._radii
            grip = self._coefficients[inside].min() if inside.any() else GRIP[0]
            self._friction[wheel, 0] = min(grip, self._limits[wheel])


class Wheels:
    """The friction of both wheels of one robot, in their bearings and on the floor."""

    def __init__(self, model: mujoco.MjModel, grip: Grip, prefix: str) -> None:
        left, right = (int(model.joint(prefix + name).dofadr[0]) for name in WHEELS)
        stop = right + (1 if right > left else -1)
        both = slice(left, None if stop < 0 else stop, right - left)
        self._friction = model.dof_frictionloss[both]
        self._impedance = model.dof_solimp[both, :2]
        self._usual = self._impedance.copy()
        self._grip = grip
        self._geoms = [model.geom(prefix + name).id for name in WHEELS]
        self._powered = True
        self._faults = WheelFaults()

    def power(self, *, on: bool) -> None:
        """Let the motors turn the wheels, or let the gears brake them."""
        self._powered = on
        self._set()

    def set_faults(self, faults: WheelFaults) -> None:
        """Replace the faults of the wheels."""
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
