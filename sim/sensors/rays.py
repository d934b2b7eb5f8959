"""Rays from a place on the base: distances for lidars, range sensors and depth cameras."""

from __future__ import annotations

from typing import TypeAlias

import mujoco
import numpy as np
import numpy.typing as npt

from sim.physics.names import MARKS, SCREENS, SOLID

Floats: TypeAlias = npt.NDArray[np.float64]


class Rays:
    """Casts rays from a place on the base.

    Args:
        model: The model of the world.
        base: The number of the base's body, which no ray hits.
        place: Where they begin, m in the frame of the base.
        directions: Unit vectors in the frame of the base, one a row. They may be changed.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        base: int,
        place: tuple[float, float, float],
        directions: Floats,
    ) -> None:
        self._model, self._base, self._place = model, base, np.array(place)
        self.directions = directions
        self._vectors = np.empty_like(directions)
        self._distances = np.empty(len(directions))
        self._hit = np.empty(len(directions), dtype=np.int32)
        self._groups = np.zeros(mujoco.mjNGROUP, dtype=np.uint8)
        self._groups[[SOLID, MARKS, SCREENS]] = 1

    def cast(self, data: mujoco.MjData, count: int) -> tuple[Floats, npt.NDArray[np.bool]]:
        """Return the distances (m) of the first `count` rays, and which of them hit nothing.

        Positions in `data` must be current. The next call overwrites the distances.
        """
        vectors, distances, hit = self._vectors[:count], self._distances[:count], self._hit[:count]
        rotation = data.xmat[self._base].reshape(3, 3)
        np.matmul(self.directions[:count], rotation.T, out=vectors)
        mujoco.mj_multiRay(
            self._model,
            data,
            data.xpos[self._base] + rotation @ self._place,
            vectors.reshape(-1),
            self._groups,
            1,  # static geoms too
            self._base,  # not its own screen; its other geoms are in groups that are left out
            hit,
            distances,
            None,
            count,
            mujoco.mjMAXVAL,
        )
        return distances, hit < 0
