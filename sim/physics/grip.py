"""How well wheels grip: less on slippery places, and where they are worn."""

from __future__ import annotations

import mujoco
import numpy as np

from sim.physics.names import GRIP, WHEELS
from sim.world.world import World

LEAST = 0.001
"""Without any friction at all MuJoCo's contacts become unstable, and throw the robot."""


class Grip:
    """Sets the friction of every wheel: by where on the floor it stands, and by its limit."""

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
        """Let a wheel, by its geom's number, grip no better than this, wherever it stands."""
        self._limits[wheel] = max(LEAST, min(coefficient, GRIP[0]))
        self._friction[wheel, 0] = self._limits[wheel]
        # Of two that touch the larger friction counts, unless one takes precedence.
        self._model.geom_priority[wheel] = coefficient < GRIP[0]

    def apply(self, data: mujoco.MjData) -> None:
        """Set it for the next step, by the places at the beginning of the one before."""
        for wheel in self._wheels:
            offsets = self._places - data.geom_xpos[wheel, :2]
            inside = np.hypot(offsets[:, 0], offsets[:, 1]) < self._radii
            grip = self._coefficients[inside].min() if inside.any() else GRIP[0]
            self._friction[wheel, 0] = min(grip, self._limits[wheel])
