"""The lidar: distances to the surroundings, one ray per direction, all at one instant.

The same rays serve range sensors and depth cameras.
"""

from __future__ import annotations

import array
import math
from collections.abc import Mapping
from statistics import NormalDist
from typing import Annotated, Any, TypeAlias

import mujoco
import numpy as np
import numpy.typing as npt
from typing_extensions import override

from bt_mission.robots.model import LidarModel, RobotModel
from sim.faults import SensorFaults, expected, within
from sim.frames import BASE_LINK, FramePose
from sim.physics.names import BASE, MARKS, SCREENS, SOLID
from sim.physics.simulator import FollowedSimulator
from sim.sensors import topics
from sim.sensors.sensor import Mount, Noise, Sensor

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


_TURN_JITTER = 0.005
"""1 sigma of the time an LDS-02 takes for a turn, relative: a few rays more or less."""

_GAP_SIGMAS = 2.576
"""Beyond this number of sigma an LDS-02's direction has no reading: 1 % of them."""

_NEAR, _MIDDLE = 0.3, 6.0
_NEAR_SIGMA, _MIDDLE_SHARE, _FAR_SHARE = 0.010 / 3, 0.03 / 3, 0.05 / 3
"""Noise of an LDS-02: its data sheet's 10 mm below 0.3 m, 3 % below 6 m and 5 % beyond, taken for
three sigma."""


Bearing = Annotated[float, within(-360, 360, "deg")]


class LidarFaults(SensorFaults):
    """A lidar that reads wrong, in part or not at all.

    A direction that is lost reads as where there is nothing: inf with an LDS-01, NaN with an
    LDS-02.
    """

    noise: Annotated[float, within(0, 10, "m")] = 0.0
    """1 sigma of normal noise on top of the sensor's own, m."""
    bias: Annotated[float, within(-10, 10, "m")] = 0.0
    """Added to every distance, m."""
    sectors: Annotated[
        tuple[tuple[Bearing, Bearing], ...],
        expected("((FROM, TO), ...) in degrees from -360 to 360, left positive"),
    ] = ()
    """Lost directions, each from a bearing counter-clockwise to another, deg; ahead is 0 and left
    positive: (-20, 20) is ahead, (160, -160) behind, (-180, 180) all.
    """
    dropout: Annotated[float, within(0, 1, "of all rays")] = 0.0
    """Share of the directions that are lost, different ones each time."""
    frozen: bool = False
    """It repeats its last scan, with fresh stamps."""


NO_LIDAR_FAULTS = LidarFaults()


class Lidar:
    """A planar lidar on the base. Ray 0 looks ahead, the others follow counter-clockwise.

    An LDS-01 measures the same number of rays at each turn; farther than `max_range` reads inf,
    as in Gazebo, nearer than `min_range` reads 0.0, as from its driver. An LDS-02 samples at a
    steady pace while its turns vary, so that the number of rays does, too, and whatever it has no
    reading for is NaN, as from its driver.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        robot: RobotModel,
        seed: int,
        prefix: str = "",
        spec: LidarModel | None = None,
        name: str = "",
    ) -> None:
        spec = spec or robot.lidar
        base, prefix = prefix, prefix + name
        self._spec = spec
        self._varies = spec.model == "LDS-02"
        self._noisy = robot.sensors.lidar.noise
        self.most_rays = (
            math.ceil(spec.rays * (1 + 6 * _TURN_JITTER)) if self._varies else spec.rays
        )
        self._yaw = math.radians(spec.yaw)
        directions = np.zeros((self.most_rays, 3))
        self._caster = Rays(model, model.body(base + BASE).id, (spec.x, spec.y, spec.z), directions)
        self._noise = Noise(seed, f"{prefix}lidar", self.most_rays)
        self._turns = Noise(seed, f"{prefix}lidar turns", 1)
        self._gaps = Noise(seed, f"{prefix}lidar gaps", self.most_rays)
        self._distortion = LidarDistortion(seed, prefix, self.most_rays, spec)
        self._rays = 0
        self._aim(spec.rays)

    def measure(
        self,
        data: mujoco.MjData,
        index: int,
        faults: LidarFaults = NO_LIDAR_FAULTS,
        simulator: FollowedSimulator | None = None,
    ) -> npt.NDArray[np.float32]:
        """Return the ranges in metres of measurement `index`; positions in `data` must be current.

        The number of rays of an LDS-02 varies. With another simulator, its distances are measured.
        """
        if self._varies:
            self._aim(self._rays_of(index))
        if simulator is None:
            seen, missed = self._caster.cast(data, self._rays)
        else:
            seen = simulator.ranges(self._rays)
            missed = np.isinf(seen)
        if faults is not NO_LIDAR_FAULTS:
            self._distortion.apply(faults, seen, missed, index)
        (self._finish_02 if self._varies else self._finish_01)(seen, missed, index)
        return seen.astype(np.float32)

    def _finish_01(
        self, seen: npt.NDArray[np.float64], missed: npt.NDArray[np.bool], index: int
    ) -> None:
        spec = self._spec
        if self._noisy:
            seen += spec.noise_std * self._noise.at(index)
        near = seen < spec.min_range
        missed |= seen > spec.max_range
        seen[near] = 0.0
        seen[missed] = np.inf

    def _finish_02(
        self, seen: npt.NDArray[np.float64], missed: npt.NDArray[np.bool], index: int
    ) -> None:
        spec, rays = self._spec, self._rays
        if self._noisy:
            share = np.where(seen < _MIDDLE, _MIDDLE_SHARE, _FAR_SHARE)
            sigma = np.where(seen < _NEAR, _NEAR_SIGMA, share * seen)
            seen += sigma * self._noise.at(index)[:rays]
            # A normal number beyond 2.576 occurs once in a hundred times.
            missed |= np.abs(self._gaps.at(index)[:rays]) > _GAP_SIGMAS
        missed |= (seen < spec.min_range) | (seen > spec.max_range)
        seen[missed] = np.nan

    def _rays_of(self, index: int) -> int:
        if not self._noisy:
            return self._spec.rays
        turn = 1 + _TURN_JITTER * float(self._turns.at(index)[0])
        return max(1, min(round(self._spec.rays * turn), self.most_rays))

    def _aim(self, rays: int) -> None:
        """Spread that many rays over a turn."""
        if rays != self._rays:
            self._rays = rays
            first, step = spec_angles(self._spec, rays)
            angles = np.arange(rays) * step + (first + self._yaw)
            directions = self._caster.directions
            directions[:rays, 0], directions[:rays, 1] = np.cos(angles), np.sin(angles)


def spec_angles(spec: LidarModel, rays: int) -> tuple[float, float]:
    """Return the bearing of the first ray in the lidar's frame, and the step to the next, rad."""
    return spec.angles if spec.sector else (0.0, math.tau / rays)


class LidarDistortion:
    """Changes the true distances of a lidar before it makes readings of them."""

    def __init__(self, seed: int, prefix: str, most_rays: int, spec: LidarModel) -> None:
        self._spec = spec
        self._noise = Noise(seed, f"{prefix}lidar fault", most_rays)
        self._dropout = Noise(seed, f"{prefix}lidar dropout", most_rays)

    def apply(
        self,
        faults: LidarFaults,
        distances: npt.NDArray[np.float64],
        missed: npt.NDArray[np.bool],
        index: int,
    ) -> None:
        """Change distances (m) and missing readings of measurement `index` in place."""
        rays = len(distances)
        distances += faults.bias
        if faults.noise:
            distances += faults.noise * self._noise.at(index)[:rays]
        if faults.dropout >= 1:
            missed[:] = True
        elif faults.dropout:
            missed |= self._dropout.at(index)[:rays] < NormalDist().inv_cdf(faults.dropout)
        for start, end in faults.sectors:
            missed |= sector(self._bearings(rays), start, end)

    def _bearings(self, rays: int) -> npt.NDArray[np.float64]:
        """Return the bearings of the rays from ahead of the base, deg."""
        if self._spec.sector is None:
            bearings = np.arange(rays) * (360 / rays)
        else:
            bearings = np.linspace(*self._spec.sector, rays)
        return bearings.astype(np.float64) + self._spec.yaw


def sector(
    bearings: npt.NDArray[np.float64], start_deg: float, end_deg: float
) -> npt.NDArray[np.bool]:
    """Return which bearings (deg, left positive) are between two others, counter-clockwise.

    Both ends belong to it.
    """
    if end_deg - start_deg >= 360:
        return np.ones(len(bearings), dtype=np.bool)
    # A ray at the start must not become just short of a full turn.
    beyond = np.round(bearings - start_deg, 9) % 360
    inside: npt.NDArray[np.bool] = beyond <= round(end_deg - start_deg, 9) % 360
    return inside


class LidarSensor(Sensor):
    """A robot's lidar, and its scans."""

    name = "lidar"
    table = "lidars"
    topic = topics.SCAN
    message = "sensor_msgs/msg/LaserScan"
    frame = "base_scan"
    is_reliable = False
    breaks = NO_LIDAR_FAULTS

    @override
    @classmethod
    def frames(cls, robot: RobotModel) -> list[FramePose]:
        spec = cls.figures(robot)
        half = math.radians(spec.yaw) / 2
        turned = (0.0, 0.0, math.sin(half), math.cos(half))
        return [FramePose(BASE_LINK, cls.frame, (spec.x, spec.y, spec.z), turned)]

    def __init__(self, mount: Mount) -> None:
        super().__init__(mount)
        name = "" if self.name == "lidar" else f"{self.name} "
        model, prefix = mount.physics.model, mount.prefix
        self._lidar = Lidar(model, mount.robot, mount.seed, prefix, self.spec, name)
        self.fields = () if self.spec.model == "LDS-02" else ("ranges",)
        self.restart()

    @override
    def restart(self) -> None:
        self._last: npt.NDArray[np.float32] | None = None
        self._index = 0

    @override
    def constants(self) -> Mapping[str, Any]:
        """Return the constants of the drivers.

        LDS-01: from 0 to one step before a full turn. All rays are measured at one instant, so the
        times between them are 0. LDS-02: ranges from 0 to 100 m, whatever the sensor measures.
        """
        spec = self.spec
        first, step = spec.angles
        least, most = (spec.min_range, spec.max_range) if self.fields else (0.0, 100.0)
        return {
            "angle_min": first,
            "angle_max": first + step * (spec.rays - 1),
            "angle_increment": step,
            "range_min": least,
            "range_max": most,
            "ranges": array.array("f", bytes(4 * spec.rays)),
        }

    def scan(self, index: int) -> npt.NDArray[np.float32]:
        """Return the ranges of measurement `index`, m."""
        faults = self.faults
        if not faults.frozen or self._last is None:
            self._last = self._measure(index)
            self._index = index
        return self._last

    def look(self) -> npt.NDArray[np.float32]:
        """Return the ranges of a full turn now, m, with the noise of the newest measurement.

        It changes nothing, so that a viewer does not change what a frozen lidar shows, and draws no
        noise.
        """
        if self.faults.frozen and self._last is not None:
            return self._turn(self._last)
        return self._turn(self._measure(self._index))

    def _turn(self, ranges: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """Return ranges as those of a full turn; the other directions read inf."""
        if self.spec.sector is None:
            return ranges
        first, step = self.spec.angles
        turn = np.full(round(math.tau / step), np.inf, dtype=np.float32)
        turn[(np.arange(len(ranges)) + round(first / step)) % len(turn)] = ranges
        return turn

    def _measure(self, index: int) -> npt.NDArray[np.float32]:
        physics = self.mount.physics
        simulator = physics.simulator if self.name == "lidar" else None
        return self._lidar.measure(physics.data, index, self.faults, simulator)

    @override
    def numbers(self, index: int) -> list[float]:
        ranges: list[float] = self.scan(index).tolist()
        return ranges

    @override
    def fill(self, message: Any, index: int) -> bool:
        """Write a full turn of any number of rays."""
        ranges = self.scan(index)
        step = math.tau / len(ranges)
        message.angle_max, message.angle_increment = step * (len(ranges) - 1), step
        message.ranges = array.array("f", ranges.tobytes())
        return True
