"""Odometry, transforms, scans and commands read where they lie, in the serialised message.

What is given looks like the message, as far as somebody here reads it: the same names, fewer of
them.
rclpy makes a Python object of every part of a message, down to each of an odometry message's 72
covariances; a control step needs a dozen numbers of it. The layout is CDR as DDS sends it (OMG
CDR, formal/2021-01-01, 15.3, encoding version 1): four bytes of header, the second of which
tells the byte order, then the fields in their order, each aligned to its own size, counted from
behind the header; a text is its length with its final zero, and its bytes.
"""

from __future__ import annotations

from functools import cache
from struct import Struct
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

HEADER = 4
COVARIANCE = 36 * 8
"""Bytes; nobody here reads one."""


class CdrError(ValueError):
    """The bytes are no message of the type."""


class Stamp(NamedTuple):
    """As `builtin_interfaces/Time`."""

    sec: int
    nanosec: int


class Header(NamedTuple):
    """As `std_msgs/Header`."""

    stamp: Stamp
    frame_id: str


class Vector3(NamedTuple):
    """As `geometry_msgs/Vector3` and `Point`."""

    x: float
    y: float
    z: float


class Quaternion(NamedTuple):
    """As `geometry_msgs/Quaternion`."""

    x: float
    y: float
    z: float
    w: float


class PoseFields(NamedTuple):
    """As `geometry_msgs/Pose`."""

    position: Vector3
    orientation: Quaternion


class Twist(NamedTuple):
    """As `geometry_msgs/Twist`."""

    linear: Vector3
    angular: Vector3


class PoseOnly(NamedTuple):
    """As `geometry_msgs/PoseWithCovariance`, without that."""

    pose: PoseFields


class TwistOnly(NamedTuple):
    """As `geometry_msgs/TwistWithCovariance`, without that."""

    twist: Twist


class OdometryFields(NamedTuple):
    """As `nav_msgs/Odometry`."""

    header: Header
    child_frame_id: str
    pose: PoseOnly
    twist: TwistOnly


class TransformFields(NamedTuple):
    """As `geometry_msgs/Transform`."""

    translation: Vector3
    rotation: Quaternion


class TransformStamped(NamedTuple):
    """As `geometry_msgs/TransformStamped`."""

    header: Header
    child_frame_id: str
    transform: TransformFields


class TwistStamped(NamedTuple):
    """As `geometry_msgs/TwistStamped`."""

    header: Header
    twist: Twist


class LaserScan(NamedTuple):
    """As `sensor_msgs/LaserScan`; the ranges are an array of 32-bit floats."""

    header: Header
    angle_min: float
    angle_max: float
    angle_increment: float
    time_increment: float
    scan_time: float
    range_min: float
    range_max: float
    ranges: npt.NDArray[np.float32]


def odometry(data: bytes) -> OdometryFields:
    """Read a `nav_msgs/Odometry`. Raises CdrError."""
    reader = _FieldReader(data)
    header, child = reader.header(), reader.text()
    pose = reader.pose()
    reader.skip(COVARIANCE)
    return OdometryFields(header, child, PoseOnly(PoseFields(*pose)), TwistOnly(reader.twist()))


def twist_stamped(data: bytes) -> TwistStamped:
    """Read a `geometry_msgs/TwistStamped`. Raises CdrError."""
    reader = _FieldReader(data)
    return TwistStamped(reader.header(), reader.twist())


def transforms(data: bytes) -> list[TransformStamped]:
    """Read a `tf2_msgs/TFMessage`. Raises CdrError."""
    reader = _FieldReader(data)
    (count,) = reader.numbers("I", 4)
    return [
        TransformStamped(reader.header(), reader.text(), TransformFields(*reader.pose()))
        for _ in range(count)
    ]


def scan(data: bytes) -> LaserScan:
    """Read a `sensor_msgs/LaserScan`. Raises CdrError."""
    reader = _FieldReader(data)
    header, limits = reader.header(), reader.numbers("7f", 4)
    return LaserScan._make((header, *limits, reader.floats()))


@cache
def _struct(order: str, layout: str) -> Struct:
    return Struct(order + layout)


class _FieldReader:
    """Reads one field after the other. Raises CdrError where the message is too short."""

    def __init__(self, data: bytes) -> None:
        if len(data) < HEADER or data[0] != 0 or data[1] > 1:
            raise CdrError("no CDR header")
        self.order = "<" if data[1] else ">"
        self._data = data
        self._at = HEADER

    def numbers(self, layout: str, size: int) -> tuple[Any, ...]:
        """Numbers of one `size` in bytes, by their letters for `struct`."""
        self._align(size)
        found = _struct(self.order, layout)
        end = self._at + found.size
        if end > len(self._data):
            raise CdrError("the message is cut")
        values = found.unpack_from(self._data, self._at)
        self._at = end
        return values

    def text(self) -> str:
        """A string."""
        (length,) = self.numbers("I", 4)
        end = self._at + length
        if not length or end > len(self._data):
            raise CdrError("the message is cut")
        text = self._data[self._at : end - 1]
        self._at = end
        return str(text, "utf-8", "replace")

    def header(self) -> Header:
        """A `std_msgs/Header`."""
        return Header(Stamp(*self.numbers("iI", 4)), self.text())

    def pose(self) -> tuple[Vector3, Quaternion]:
        """A place and an orientation."""
        seven = self.numbers("7d", 8)
        return Vector3(*seven[:3]), Quaternion(*seven[3:])

    def twist(self) -> Twist:
        """A velocity and a turn rate."""
        six = self.numbers("6d", 8)
        return Twist(Vector3(*six[:3]), Vector3(*six[3:]))

    def floats(self) -> npt.NDArray[np.float32]:
        """A sequence of 32-bit floats."""
        (count,) = self.numbers("I", 4)
        end = self._at + 4 * count
        if end > len(self._data):
            raise CdrError("the message is cut")
        values = np.frombuffer(self._data, f"{self.order}f4", count, self._at)
        self._at = end
        return values.astype(np.float32)

    def skip(self, size: int) -> None:
        """Pass over so many bytes."""
        self._at += size

    def _align(self, size: int) -> None:
        self._at += -(self._at - HEADER) % size
