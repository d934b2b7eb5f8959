"""The true clearance between the robot's hull and wheels and everything that they could touch."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import sub

import mujoco
import numpy as np
import numpy.typing as npt

from sim.physics.names import BASE, FLOOR, LOOSE_BIT, NOWHERE, OBSTACLE_BIT, PROP_PREFIX, WHEELS

Point = tuple[float, float, float]

_FAR = 1e3
"""Metres. MuJoCo looks no farther than its limit; no world is as large as this."""
_SLACK = 1e-5
"""Metres; more than the error of bounds and distances."""
_STRIDE = 0.2
"""Metres that the robot may move until the bounds to all fixed obstacles are computed again."""


@dataclass(frozen=True, slots=True)
class Clearance:
    """The smallest distance (m), negative for a penetration, and the obstacle.

    `here` is the nearest point of the robot and `there` that of the obstacle, in the map (m).
    Without an obstacle within the limit of the request, the distance is that limit and the rest
    None.
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
        self._was_formed = [axis.tolist() for axis in self._form]
        self._is_spare = model.geom_group[geom] == NOWHERE

    def way(self, reach: float) -> float:
        """Return the farthest that a point of it can have moved, m; infinite if it is new.

        A rigid motion moves no point by more than its translation and the chord of its turn.

        Args:
            reach: The greatest distance of a point from the middle, m.
        """
        if [axis.tolist() for axis in self._form] != self._was_formed:
            return math.inf
        if self._is_spare:
            return 0.0
        return self.moved() + self.turned(reach)

    def moved(self) -> float:
        """Return how far its middle has moved, m."""
        return math.dist(self._place.tolist(), self._was_at)

    def turned(self, reach: float) -> float:
        """Return the farthest that its turn can have moved a point so far from its middle, m."""
        # The Frobenius norm of the difference of two rotations by t is 2 sqrt(2) sin(t / 2).
        return math.dist(self._turn.tolist(), self._was_turned) * math.sqrt(0.5) * reach


class _Box:
    """The box round a geom, wherever it is."""

    def __init__(self, data: mujoco.MjData, model: mujoco.MjModel, geom: int) -> None:
        self.geom = geom
        self._place, self._turn = data.geom_xpos[geom], data.geom_xmat[geom]
        self._half = model.geom_aabb[geom, 3:]
        self._group = model.geom_group[geom : geom + 1]

    @property
    def is_there(self) -> bool:
        """Whether it counts. Spare bodies do not."""
        return bool(self._group[0] != NOWHERE)

    def distance(self, point: Sequence[float]) -> float:
        """Return the distance of a point in the map, m."""
        dx, dy, dz = map(sub, point, self._place.tolist())
        ax, ay, az, bx, by, bz, cx, cy, cz = self._turn.tolist()
        x, y, z = self._half.tolist()
        return math.hypot(
            max(0.0, abs(ax * dx + bx * dy + cx * dz) - x),
            max(0.0, abs(ay * dx + by * dy + cy * dz) - y),
            max(0.0, abs(az * dx + bz * dy + cz * dz) - z),
        )


@dataclass(frozen=True)
class _Surroundings:
    """Fixed obstacles, with lower bounds of the distance to each, and obstacles that may move.

    Attributes:
        standing: The nearest first; each with a bound (m) for the robot at `place`.
    """

    data: mujoco.MjData
    place: list[float]
    standing: list[tuple[float, _Box]]
    moving: tuple[_Box, ...]


@dataclass(frozen=True)
class _MeasuredClearance:
    """A clearance (m) that was measured, and where the two sides stood then."""

    least: float
    least_round: float
    """A bound for the ball round the robot: it does not depend on the robot's heading."""
    data: mujoco.MjData
    own: _Placed
    others: tuple[tuple[_Placed, float], ...]


class Gauge:
    """Measures from the geoms `own` of one rigid body to those of `others`, by their numbers.

    `names` are the reported names of geoms. Spare bodies among the others do not count.
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
        self._surroundings: _Surroundings | None = None
        self._boxes: dict[int, _Box] = {}
        is_moving = model.body_weldid[model.geom_bodyid[self._others]] != 0
        self._standing = self._others[~is_moving]
        self._moving = [
            (int(other), float(model.geom_rbound[other])) for other in self._others[is_moving]
        ]

    def measure(self, data: mujoco.MjData, within: float = math.inf) -> Clearance:
        """Return the clearance; the places of geoms in `data` must be current.

        Obstacles at a distance of `within` m or more are ignored.
        """
        best, least, fromto = Clearance(within), min(within, _FAR), self._fromto
        near = self._near(data, min(least, self._at_most(data)))
        self._known = None
        model, distance = self._model, mujoco.mj_geomDistance
        for bound, other in near:
            if bound >= least:
                break
            for geom in self._own:
                gap = distance(model, data, geom, other, least, fromto)
                if gap < least:
                    least = gap
                    x, y, z, *there = fromto.tolist()
                    best = Clearance(
                        gap, self._names[other], (x, y, z), (there[0], there[1], there[2])
                    )
        if math.isinf(within):
            moving = ((_Placed(data, model, other), reach) for other, reach in self._moving)
            least_round = near[0][0] if near else least
            self._known = _MeasuredClearance(
                least, least_round - _SLACK, data, _Placed(data, model, self._own[0]), tuple(moving)
            )
        return best

    def at_least(self, data: mujoco.MjData) -> float:
        """Return a lower bound of the clearance (m); the places of geoms must be current.

        It is the last measured clearance, without the farthest that any point of the two sides can
        have moved since; or that of a ball round the robot, which turning does not move. Without
        such a clearance it is measured.
        """
        known = self._known
        farthest = math.inf if known is None else self._way_of_others(known, data)
        if known is None or math.isinf(farthest):
            return self.measure(data).distance
        least = max(known.least - known.own.turned(self._ball), known.least_round)
        return least - known.own.moved() - farthest

    def _at_most(self, data: mujoco.MjData) -> float:
        """Return an upper bound of the clearance, m; infinite without an earlier measurement."""
        known = self._known
        if known is None:
            return math.inf
        return known.least + known.own.way(self._ball) + self._way_of_others(known, data)

    def _way_of_others(self, known: _MeasuredClearance, data: mujoco.MjData) -> float:
        """Return the farthest that any obstacle has moved since, m; infinite if that is unknown."""
        if known.data is not data:
            return math.inf
        return max((other.way(reach) for other, reach in known.others), default=0.0)

    def _near(self, data: mujoco.MjData, within: float) -> list[tuple[float, int]]:
        """Return what may be so near, the nearest first, each with a bound of its distance, m."""
        place = data.geom_xpos[self._own[0]].tolist()
        around = self._surroundings
        moved = math.inf
        if around is not None and around.data is data:
            moved = math.dist(place, around.place)
        if around is None or moved > _STRIDE:
            around, moved = self._look_around(data, place), 0.0
        boxes = [box for box in around.moving if box.is_there]
        for bound, box in around.standing:
            if bound - moved >= within + _SLACK:
                break
            boxes.append(box)
        ball = self._ball
        return sorted((box.distance(place) - ball, box.geom) for box in boxes)

    def _look_around(self, data: mujoco.MjData, place: list[float]) -> _Surroundings:
        """Compute and keep the bounds to all fixed obstacles."""
        if self._surroundings is None or self._surroundings.data is not data:
            self._boxes = {geom: _Box(data, self._model, geom) for geom in self._others.tolist()}
        standing = self._standing
        bounds = self._bounds(data, standing)
        order = np.argsort(bounds)
        pairs = zip(bounds[order].tolist(), standing[order].tolist(), strict=True)
        self._surroundings = around = _Surroundings(
            data,
            place,
            [(bound, self._boxes[geom]) for bound, geom in pairs],
            tuple(self._boxes[geom] for geom, _ in self._moving),
        )
        return around

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
    """Return the gauge from one robot to everything that it could touch, other robots too."""
    own = touching(model, prefix)
    root = model.body_rootid[model.geom_bodyid]
    meets = model.geom_conaffinity[own].max() & ~LOOSE_BIT
    others = [
        geom
        for geom in range(model.ngeom)
        if root[geom] != root[own[0]]
        and (model.geom_contype[geom] & meets or model.geom(geom).name.startswith(PROP_PREFIX))
        and geom != model.geom(FLOOR).id
    ]
    return Gauge(model, names, own, others)


def touching(model: mujoco.MjModel, prefix: str = "") -> list[int]:
    """Return the geoms of a robot that touch obstacles: its hull, then its wheels.

    An arm is no part of the rigid body from which clearance is measured.
    """
    base = model.body(prefix + BASE).id
    wheels = {prefix + name for name in WHEELS}
    return [
        geom
        for geom in range(model.ngeom)
        if (model.body_weldid[model.geom_bodyid[geom]] == base or model.geom(geom).name in wheels)
        and model.geom_conaffinity[geom] & OBSTACLE_BIT
    ]


def _ball(model: mujoco.MjModel, own: Sequence[int]) -> float:
    """Return the radius (m) round the first geom's centre that holds them all."""
    places = []
    for geom in own:
        body, place = int(model.geom_bodyid[geom]), model.geom_pos[geom].copy()
        while model.body_rootid[body] != body:
            mujoco.mju_rotVecQuat(place, place.copy(), model.body_quat[body])
            place += model.body_pos[body]
            body = int(model.body_parentid[body])
        places.append(place)
    return max(
        float(np.linalg.norm(place - places[0]) + model.geom_rbound[geom])
        for place, geom in zip(places, own, strict=True)
    )
