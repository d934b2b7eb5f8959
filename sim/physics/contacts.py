"""Collisions: a robot coming into contact with anything but the floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from sim.physics.names import BASE, FLOOR, LOOSE_BIT, OBSTACLE_PREFIX

RELEASE_NS = 250_000_000
"""A contact that ends for this long, ns, is over; an earlier touch belongs to the same collision.
"""


@dataclass(frozen=True, slots=True)
class Collision:
    """One onset of contact: time, obstacle, place in the map (m), and normal force (N).

    Attributes:
        is_robot: Whether the obstacle is another robot.
    """

    time_ns: int
    obstacle: str
    point: tuple[float, float, float]
    force: float
    is_robot: bool = False


class Contacts:
    """Distinguishes onsets from contacts that last, slide or bounce.

    `names` are the reported names of geoms, and may change.
    """

    def __init__(self, model: mujoco.MjModel, names: Sequence[str], prefix: str = "") -> None:
        self._model = model
        self._names = names
        robot = model.body(prefix + BASE).id
        root = model.body_rootid[model.geom_bodyid]
        self._is_robot = root == robot
        self._is_other_robot = _robot_geoms(model) & ~self._is_robot
        self._is_obstacle = (
            (root != robot)
            & (np.arange(model.ngeom) != model.geom(FLOOR).id)
            & (model.geom_contype != LOOSE_BIT)  # a robot may push and grip these
        )
        self._last_touch_ns: dict[str, int] = {}
        self._force = np.empty(6)

    def look(self, data: mujoco.MjData, time_ns: int) -> list[Collision]:
        """Return the collisions that begin now. To be called at every step with a contact."""
        begun = []
        for name, index in self.touched(data).items():
            last = self._last_touch_ns.get(name)
            self._last_touch_ns[name] = time_ns
            if last is None or time_ns - last > RELEASE_NS:
                begun.append(self._collision(data, index, name, time_ns))
        return begun

    def touched(self, data: mujoco.MjData) -> dict[str, int]:
        """Return what is being touched, and the number of a contact with it."""
        touched: dict[str, int] = {}
        geoms = data.contact.geom
        touches = self._is_robot[geoms] & self._is_obstacle[geoms[:, ::-1]]
        for index, side in np.argwhere(touches).tolist():
            touched.setdefault(self._names[geoms[index, 1 - side]], index)
        return touched

    def places(self, data: mujoco.MjData) -> npt.NDArray[np.float64]:
        """Return where the robot is being touched, `n x 2` m on the map."""
        geoms = data.contact.geom
        touches = (self._is_robot[geoms] & self._is_obstacle[geoms[:, ::-1]]).any(axis=1)
        places: npt.NDArray[np.float64] = data.contact.pos[touches, :2]
        return places

    def forget(self) -> None:
        """Start again: the next touch of an obstacle is a new collision."""
        self._last_touch_ns.clear()

    def _collision(self, data: mujoco.MjData, index: int, name: str, time_ns: int) -> Collision:
        mujoco.mj_contactForce(self._model, data, index, self._force)
        x, y, z = data.contact.pos[index].tolist()
        is_robot = bool(self._is_other_robot[data.contact.geom[index]].any())
        return Collision(time_ns, name, (x, y, z), float(self._force[0]), is_robot)


def _robot_geoms(model: mujoco.MjModel) -> npt.NDArray[np.bool_]:
    """Return for each geom whether it is a part of a robot."""
    names = [str(model.body(int(model.body_rootid[body])).name) for body in model.geom_bodyid]
    return np.array([name == BASE or name.endswith(f"/{BASE}") for name in names], np.bool_)


def geom_names(model: mujoco.MjModel) -> list[str]:
    """Return the reported name of each geom. Spare ones have no name until they are placed."""
    return [_name(model, geom) for geom in range(model.ngeom)]


def _name(model: mujoco.MjModel, geom: int) -> str:
    """Return what a geom is reported as: the obstacle, or the robot that it is a part of."""
    name = str(model.geom(geom).name)
    if name.startswith(OBSTACLE_PREFIX):
        return name.removeprefix(OBSTACLE_PREFIX)
    root = int(model.body_rootid[model.geom_bodyid[geom]])
    return str(model.body(root).name).removesuffix(f"/{BASE}")
