"""Collisions: the robot coming into contact with anything but the floor."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from sim.names import BASE, OBSTACLE_PREFIX, OBSTACLES

RELEASE_NS = 250_000_000
"""An obstacle not touched for this long, ns, is let go of; touched sooner, it is one collision."""


@dataclass(frozen=True, slots=True)
class Collision:
    """One onset of contact: when, with what, where in the map (m), and its normal force (N)."""

    time_ns: int
    obstacle: str
    point: tuple[float, float, float]
    force: float


class Contacts:
    """Tells onsets from contacts that last, slide or bounce."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model = model
        robot = model.body(BASE).id
        obstacles = model.body(OBSTACLES).id
        self._is_robot = model.body_rootid[model.geom_bodyid] == robot
        self._is_obstacle = model.geom_bodyid == obstacles
        self._last_touch_ns: dict[int, int] = {}
        self._force = np.empty(6)

    def look(self, data: mujoco.MjData, time_ns: int) -> list[Collision]:
        """Return the collisions that begin now. To be called at every step with a contact."""
        touched: dict[int, int] = {}
        for index in range(data.ncon):
            for geom, other in (data.contact.geom[index], data.contact.geom[index][::-1]):
                if self._is_robot[geom] and self._is_obstacle[other]:
                    touched.setdefault(int(other), index)
        begun = []
        for geom, index in touched.items():
            last = self._last_touch_ns.get(geom)
            self._last_touch_ns[geom] = time_ns
            if last is None or time_ns - last > RELEASE_NS:
                begun.append(self._collision(data, index, geom, time_ns))
        return begun

    def _collision(self, data: mujoco.MjData, index: int, geom: int, time_ns: int) -> Collision:
        mujoco.mj_contactForce(self._model, data, index, self._force)
        x, y, z = data.contact.pos[index].tolist()
        name = self._model.geom(geom).name.removeprefix(OBSTACLE_PREFIX)
        return Collision(time_ns, name, (x, y, z), float(self._force[0]))
