"""How much room there truly is: from the robot's hull and wheels to whatever they could touch."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from sim.physics.names import BASE, FLOOR, NOWHERE, OBSTACLE_BIT, PROP_PREFIX

Point = tuple[float, float, float]

_FAR = 1e3
"""Metres. MuJoCo looks no farther than it is told; no world is as large as this."""


@dataclass(frozen=True, slots=True)
class Clearance:
    """The smallest distance (m), below 0 where they are in each other, and what is so near.

    `here` is the nearest point of the robot and `there` that of the obstacle, in the map (m).
    Where there is nothing, or nothing within what was asked for, the distance is that limit and
    the rest None.
    """

    distance: float
    obstacle: str | None = None
    here: Point | None = None
    there: Point | None = None


class _Placed:
    """A geom, and how it was when a clearance was measured."""

    def __init__(self, data: mujoco.MjData, model: mujoco.MjModel, geom: int) -> None:
        self._place, self._turn = data.geom_xpos[geom], data.geom_xmat[geom]
        self._form = model.geom_size[geom], model.geom_group[geom : geom + 1]
        self._was_at, self._was_turned = self._place.tolist(), self._turn.tolist()
        self._was_formed = [one.tolist() for one in self._form]
        self._is_spare = model.geom_group[geom] == NOWHERE

    def way(self, reach: float) -> float:
        """Return the farthest that a point of it can have moved, m; infinite where it is new.

        A rigid motion moves no point by more than its translation and the chord of its turn.

        Args:
            reach: The greatest distance of a point from the middle, m.
        """
        if [one.tolist() for one in self._form] != self._was_formed:
            return math.inf
        if self._is_spare:
            return 0.0
        moved = math.dist(self._place.tolist(), self._was_at)
        # The Frobenius norm of the difference of two rotations by t is 2 sqrt(2) sin(t / 2).
        return moved + math.dist(self._turn.tolist(), self._was_turned) * math.sqrt(0.5) * reach


@dataclass(frozen=True)
class _MeasuredClearance:
    """A clearance (m) that was measured, and where the two sides stood then."""

    least: float
    data: mujoco.MjData
    own: _Placed
    others: tuple[tuple[_Placed, float], ...]


class Gauge:
    """Measures from the geoms `own` of one rigid thing to those of `others`, by their numbers.

    `names` are what geoms are reported as. Spare bodies among the others do not count.
    """

    def __init__(
        self, model: mujoco.MjModel, names: Sequence[str], own: Sequence[int], others: Sequence[int]
    ) -> None:
        self._model = model
        self._names = names
        self._own = tuple(own)
        self._others = np.array(others, dtype=np.intp)
        self._fromto = np.empty(6)
        self._ball = _ball(model, self._own)
        self._known: _MeasuredClearance | None = None
        is_moving = model.body_weldid[model.geom_bodyid[self._others]] != 0
        self._moving = [
            (int(one), float(model.geom_rbound[one])) for one in self._others[is_moving]
        ]

    def measure(self, data: mujoco.MjData, within: float = math.inf) -> Clearance:
        """Return the clearance; the places of geoms in `data` must be current.

        What is `within` m away or farther is not looked at.
        """
        best, least, fromto = Clearance(within), min(within, _FAR), self._fromto
        self._known = None
        model, distance = self._model, mujoco.mj_geomDistance
        others = self._others[model.geom_group[self._others] != NOWHERE]
        bounds = self._bounds(data, others)
        for index in np.argsort(bounds, kind="stable").tolist():
            if bounds[index] >= least:
                break
            other = int(others[index])
            for geom in self._own:
                found = distance(model, data, geom, other, least, fromto)
                if found < least:
                    least = found
                    x, y, z, *there = fromto.tolist()
                    best = Clearance(
                        found, self._names[other], (x, y, z), (there[0], there[1], there[2])
                    )
        if math.isinf(within):
            moving = ((_Placed(data, model, one), reach) for one, reach in self._moving)
            self._known = _MeasuredClearance(
                least, data, _Placed(data, model, self._own[0]), tuple(moving)
            )
        return best

    def at_least(self, data: mujoco.MjData) -> float:
        """Return a lower bound of the clearance (m); the places of geoms must be current.

        It is the last clearance that was measured, without the farthest that any point of the two
        sides can have moved since. Without such a clearance it is measured.
        """
        known = self._known
        if known is None or known.data is not data:
            return self.measure(data).distance
        farthest = max((other.way(reach) for other, reach in known.others), default=0.0)
        if math.isinf(farthest):
            return self.measure(data).distance
        return known.least - known.own.way(self._ball) - farthest

    def _bounds(self, data: mujoco.MjData, others: npt.NDArray[np.intp]) -> npt.NDArray[np.float64]:
        """Return a lower bound (m) of the distance to each: between a ball and a box."""
        turns = data.geom_xmat[others].reshape(-1, 3, 3)
        offsets = data.geom_xpos[self._own[0]] - data.geom_xpos[others]
        offsets = np.einsum("nij,ni->nj", turns, offsets)
        beyond = np.abs(offsets) - self._model.geom_aabb[others, 3:]
        bounds: npt.NDArray[np.float64] = (
            np.linalg.norm(np.maximum(beyond, 0.0), axis=1) - self._ball
        )
        return bounds


def robot_gauge(model: mujoco.MjModel, names: Sequence[str], prefix: str = "") -> Gauge:
    """Return what measures from one robot to all that it could touch, other robots too."""
    own = touching(model, prefix)
    root = model.body_rootid[model.geom_bodyid]
    meets = model.geom_conaffinity[own].max()
    others = [
        geom
        for geom in range(model.ngeom)
        if root[geom] != root[own[0]]
        and (model.geom_contype[geom] & meets or model.geom(geom).name.startswith(PROP_PREFIX))
        and geom != model.geom(FLOOR).id
    ]
    return Gauge(model, names, own, others)


def touching(model: mujoco.MjModel, prefix: str = "") -> list[int]:
    """Return the geoms of a robot that touch obstacles: its hull, then its wheels."""
    base = model.body(prefix + BASE).id
    return [
        geom
        for geom in range(model.ngeom)
        if model.body_rootid[model.geom_bodyid[geom]] == base
        and model.geom_conaffinity[geom] & OBSTACLE_BIT
    ]


def _ball(model: mujoco.MjModel, own: Sequence[int]) -> float:
    """Return the radius (m) round the first geom's centre that holds them all."""
    places = []
    for geom in own:
        body = model.geom_bodyid[geom]
        is_base = model.body_rootid[body] == body
        places.append(model.geom_pos[geom] + (0.0 if is_base else model.body_pos[body]))
    return max(
        float(np.linalg.norm(place - places[0]) + model.geom_rbound[geom])
        for place, geom in zip(places, own, strict=True)
    )
