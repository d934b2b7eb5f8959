"""The declaration of a sensor: its figures, its frame, its topic, and its faults.

Seeded sensor noise, addressed by sensor and measurement.

The noise of measurement `index` of a sensor depends on the seed, the sensor's name and the index
alone: not on which other sensors exist, nor on which measurements were skipped.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from bt_mission.robots.model import RobotModel
from sim.faults import RobotFaultState, SensorFaults
from sim.frames import BASE_LINK, FramePose
from sim.physics.physics import Physics
from sim.sensors.topics import topic_of

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


@dataclass(frozen=True, slots=True)
class Mount:
    """The robot that carries a sensor. `start_yaw` is its heading at the start, rad."""

    physics: Physics
    robot: RobotModel
    prefix: str
    seed: int
    start_yaw: float
    faults: RobotFaultState


class Sensor:
    """A sensor of one robot, and the topic on which its measurements are published.

    A subclass is one kind of sensor. The numbers of a message that change from one measurement to
    the next are `fields`, and `numbers` returns them; where `fields` is empty, `fill` writes each
    message.
    """

    name: ClassVar[str]
    """Of its figures in `RobotModel`, and of the part that can break."""
    topic: ClassVar[str]
    message: ClassVar[str]
    """The type of its messages, such as sensor_msgs/msg/Imu."""
    frame: ClassVar[str] = ""
    """The frame of its measurements; empty if they have no place."""
    is_reliable: ClassVar[bool] = True
    """False: published best effort."""
    is_latched: ClassVar[bool] = False
    """Published for late subscribers, too."""
    is_camera: ClassVar[bool] = False
    table: ClassVar[str] = ""
    """Of several sensors with names: the field of `RobotModel` that has them."""
    breaks: ClassVar[SensorFaults] = SensorFaults()
    """Its faults, all absent; while nothing is wrong, `faults` is this object."""

    def __init__(self, mount: Mount) -> None:
        self.mount = mount
        self.spec: Any = self.figures(mount.robot)
        self.fields: tuple[str, ...] = ()
        """Dotted names of floats, or of lists of floats, in the order of the message."""
        self.notice = ""
        """A note on how it measures, to be logged once."""

    @classmethod
    def figures(cls, robot: RobotModel) -> Any:
        """Return the figures of a robot's sensor of this kind, or None without one."""
        return getattr(robot, cls.name)

    @classmethod
    def frames(cls, robot: RobotModel) -> list[FramePose]:
        """Return the frames that the sensor adds to those of the robot."""
        spec = cls.figures(robot)
        return [FramePose(BASE_LINK, cls.frame, (spec.x, spec.y, spec.z))] if cls.frame else []

    @property
    def rate(self) -> float:
        """Measurements a second, Hz."""
        rate: float = self.spec.rate
        return rate

    @property
    def faults(self) -> Any:
        """The present faults."""
        return self.mount.faults.now[self.name]

    def restart(self) -> None:
        """Be as at the start."""

    def constants(self) -> Mapping[str, Any]:
        """Return the fields of a message that never change, by their dotted names."""
        return {}

    def numbers(self, index: int) -> Sequence[float]:
        """Return the numbers of `fields` in measurement `index`, which counts from the start."""
        raise NotImplementedError

    def fill(self, message: Any, index: int) -> bool:  # noqa: ARG002 - of others
        """Write measurement `index` into the message, which is always the same.

        Return whether it is to be published.
        """
        return True

    def close(self) -> None:
        """Give back what it holds. It measures no more."""


_NAMED: dict[tuple[type[Sensor], str], type[Sensor]] = {}


def named(kind: type[Sensor], name: str) -> type[Sensor]:
    """Return the kind of a sensor with a name in the robot's file; always the same.

    The name follows those of part, topic and frame: `range_front`.
    """

    def figures(cls: type[Sensor], robot: RobotModel) -> Any:
        return getattr(robot, cls.table).get(name)

    if (kind, name) not in _NAMED:
        fields = {
            "name": f"{kind.name}_{name}",
            "topic": topic_of(kind.topic, name),
            "frame": kind.frame and f"{kind.frame}_{name}",
            "figures": classmethod(figures),
        }
        _NAMED[kind, name] = type(f"{kind.__name__}_{name}", (kind,), fields)
    return _NAMED[kind, name]
