"""What faults make of measurements."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np
import numpy.typing as npt

from sim.faults import CameraFaults, LidarFaults
from sim.sensors.canvas import Image
from sim.sensors.noise import Noise, PictureNoise


class LidarDistortion:
    """Changes the true distances of a lidar before it makes readings of them."""

    def __init__(self, seed: int, prefix: str, most_rays: int) -> None:
        self._noise = Noise(seed, f"{prefix}lidar fault", most_rays)
        self._dropout = Noise(seed, f"{prefix}lidar dropout", most_rays)

    def apply(
        self,
        faults: LidarFaults,
        distances: npt.NDArray[np.float64],
        missed: npt.NDArray[np.bool],
        index: int,
    ) -> None:
        """Change both in place: distances (m), and where there is none, in measurement `index`."""
        rays = len(distances)
        distances += faults.bias
        if faults.noise:
            distances += faults.noise * self._noise.at(index)[:rays]
        if faults.dropout >= 1:
            missed[:] = True
        elif faults.dropout:
            missed |= self._dropout.at(index)[:rays] < NormalDist().inv_cdf(faults.dropout)
        for start, end in faults.sectors:
            missed |= sector(rays, start, end)


def sector(rays: int, start_deg: float, end_deg: float) -> npt.NDArray[np.bool]:
    """Return which rays of a full turn lie from one bearing counter-clockwise to another.

    Ray 0 looks ahead; both ends belong to it.
    """
    if end_deg - start_deg >= 360:
        return np.ones(rays, dtype=np.bool)
    bearings = np.arange(rays) * (360 / rays)
    # A ray that points at the start must not come out as just short of a full turn.
    beyond = np.round(bearings - start_deg, 9) % 360
    inside: npt.NDArray[np.bool] = beyond <= round(end_deg - start_deg, 9) % 360
    return inside


class PictureDistortion:
    """Changes a camera's pictures."""

    def __init__(self, seed: int, prefix: str) -> None:
        self._noise = PictureNoise(seed, f"{prefix}camera fault")

    def apply(self, faults: CameraFaults, pixels: Image, index: int) -> None:
        """Change picture `index` in place."""
        if faults.black:
            pixels[:] = 0
        if faults.noise:
            self._noise.add(pixels, index, faults.noise)
