"""The declaration of a sensor: its figures, its frame, its topic, and its faults."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from bt_mission.robots.model import RobotModel
from sim.faults import RobotFaultState, SensorFaults
from sim.frames import BASE_LINK, FramePose
from sim.physics.physics import Physics
from sim.sensors.topics import topic_of


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
