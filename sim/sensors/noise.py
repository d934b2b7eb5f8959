"""Seeded sensor noise, addressed by sensor and measurement.

The noise of measurement `index` of a sensor depends on the seed, the sensor's name and the index
alone: not on which other sensors exist, nor on which measurements were skipped.
"""

from __future__ import annotations

import zlib

import numpy as np
import numpy.typing as npt

_BLOCK = 64
"""Measurements drawn at once: making a generator costs as much as a thousand of its numbers."""

PICTURE_SIGMA = 0.007
"""Noise of a camera, as a share of full scale [SDF]."""


class Noise:
    """Normal noise for one sensor: `size` independent values of standard deviation 1 each time."""

    def __init__(self, seed: int, sensor: str, size: int) -> None:
        self._key = (seed % 2**63, zlib.crc32(sensor.encode()))
        self._size = size
        self._block_index = -1
        self._block: npt.NDArray[np.float64] = np.empty((0, size))

    def at(self, index: int) -> npt.NDArray[np.float64]:
        """Return the values of measurement `index` (from 0); do not write to them."""
        block, row = divmod(index, _BLOCK)
        if block != self._block_index:
            generator = np.random.default_rng((*self._key, block))
            self._block = generator.standard_normal((_BLOCK, self._size))
            self._block_index = block
        values: npt.NDArray[np.float64] = self._block[row]
        return values


class PictureNoise:
    """Noise of a camera, independent for each channel of each pixel."""

    def __init__(self, seed: int, sensor: str) -> None:
        self._key = (seed % 2**63, zlib.crc32(sensor.encode()))

    def add(self, pixels: npt.NDArray[np.uint8], index: int, sigma: float = PICTURE_SIGMA) -> None:
        """Change picture `index` (from 0) in place; `sigma` is a share of full scale."""
        noise = self.normal(pixels.shape, index)
        noise *= 255 * sigma
        noise += pixels
        np.clip(np.rint(noise, out=noise), 0, 255, out=noise)
        pixels[:] = noise

    def normal(self, shape: int | tuple[int, ...], index: int) -> npt.NDArray[np.float32]:
        """Return the normal noise of picture `index`, of standard deviation 1."""
        generator = np.random.default_rng((*self._key, index))
        return generator.standard_normal(shape, dtype=np.float32)
