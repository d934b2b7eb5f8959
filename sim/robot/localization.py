"""The robot's estimate of its pose on the map: as a particle filter, off by an error.

It follows AMCL of Nav2: between two updates it moves by odometry, and it is updated when the robot
has moved 0.25 m or turned 0.2 rad (`update_min_d` and `update_min_a`). With each update the error
changes, so the pose on the map jumps a little.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from bt_mission.base.nature import generator
from sim.frames import Vector, map_to_odom, on_map

UPDATE_M = 0.25
UPDATE_RAD = 0.2

_KEPT = 0.8
"""The part of an error that remains after an update (an assumption): half is gone after three."""


@dataclass(frozen=True)
class LocalizationError:
    """The size of the error.

    Attributes:
        place: Standard deviation along x and along y, m.
        yaw: Standard deviation of the heading, rad.
        jumps: How often it jumps, Hz, while the robot moves.
        jump: The length of a jump, m.
    """

    place: float = 0.0
    yaw: float = 0.0
    jumps: float = 0.0
    jump: float = 0.0


class Localization:
    """Places the odometry frame on the map.

    Args:
        error: None is the truth.
        seed: The seed of the errors.
        robot: The name of the robot; empty for one alone.
    """

    def __init__(self, error: LocalizationError | None, seed: int, robot: str) -> None:
        self._error = error
        self._key = seed, "localization", robot
        self.restart()

    def restart(self) -> None:
        """Begin as at the start."""
        self._generator = generator(*self._key)
        self._off: Vector = (0.0, 0.0, 0.0)
        self._updated: tuple[Vector, int] | None = None
        self._place: Vector = (0.0, 0.0, 0.0)

    def map_to_odom(self, pose: Vector, odom: Vector, time_ns: int) -> Vector:
        """Return the odometry frame's place on the map (m, m, rad).

        Args:
            pose: The base's true pose on the map.
            odom: Its pose by odometry.
            time_ns: Of both.
        """
        if self._error is None:
            return map_to_odom(pose, odom)
        if self._is_due(odom):
            self._update(self._error, time_ns)
            self._updated = odom, time_ns
            off = self._off
            believed = pose[0] + off[0], pose[1] + off[1], pose[2] + off[2]
            self._place = map_to_odom(believed, odom)
        return self._place

    def believed(self, pose: Vector, odom: Vector) -> Vector:
        """Return the base's pose on the map by the last update: that which `map_to_odom` gives.

        Args:
            pose: The base's true pose on the map.
            odom: Its pose by odometry.
        """
        return pose if self._error is None else on_map(self._place, odom)

    def _is_due(self, odom: Vector) -> bool:
        if self._updated is None:
            return True
        before = self._updated[0]
        turned = abs(math.remainder(odom[2] - before[2], math.tau))
        return math.dist(odom[:2], before[:2]) >= UPDATE_M or turned >= UPDATE_RAD

    def _update(self, error: LocalizationError, time_ns: int) -> None:
        """Draw the error of an update, which depends on the one before."""
        draw = self._generator
        numbers = draw.gauss(), draw.gauss(), draw.gauss()
        chance, direction = draw.random(), math.tau * draw.random()
        sigmas = error.place, error.place, error.yaw
        kept = 0.0 if self._updated is None else _KEPT
        fresh = math.sqrt(1 - kept * kept)
        pairs = zip(self._off, sigmas, numbers, strict=True)
        x, y, yaw = (kept * off + fresh * sigma * number for off, sigma, number in pairs)
        if self._updated is not None and chance < error.jumps * (time_ns - self._updated[1]) / 1e9:
            x += error.jump * math.cos(direction)
            y += error.jump * math.sin(direction)
        self._off = x, y, yaw
