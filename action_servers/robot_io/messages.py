"""Between ROS messages and the pure types of maneuvers: each message is translated in one place.

One scan of several lidars, as from a lidar that turns in the place of the first.

A direction of the merged scan holds the nearest point that any lidar measured there. Its stamp is
the oldest of all, so that the governor stops the base when one of the lidars is silent.
"""

from __future__ import annotations

import importlib
import math
from array import array
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from action_servers.core.maneuver import Fields, Grid, Image, JointReadings, Scan
from bt_mission.base.geometry import Pose2D, Twist2D, set_planar, yaw_about_z
from bt_mission.base.stamps import NS, set_ns, to_ns
from bt_mission.cdr.decoder import decoder_of
from bt_mission.cdr.picker import Picked, Picker
from bt_mission.robots.model import LidarModel

MAP_FRAME = "map"

MOST_RAYS = 20_000
"""Rays of a scan: the finest lidars have some thousand, and a control step looks at each."""

LEAST_INCREMENT_RAD = 1e-5
FARTHEST_M = 1e8
"""Larger coordinates, m, are invalid; those of UTM reach 1e7."""

LEAST_CELL_M, MOST_CELL_M = 1e-3, 100.0
"""Edges of the cells of a map, m."""

_CHANNELS = {"rgb8": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4, "mono8": 1}
_NUMBERS = {"float", "double"}
_TEXTS = {"string", "wstring"}
_TIMES = {"builtin_interfaces/Duration", "builtin_interfaces/Time"}
_SEQUENCE = "sequence<"


@dataclass(frozen=True, slots=True)
class OdometryMessage:
    """One odometry message: pose in `frame`, velocity of the base, stamp in seconds."""

    stamp_s: float
    frame: str
    pose: Pose2D
    velocity: Twist2D


def stamp_of(header: Any) -> float:
    """Return the stamp of a `std_msgs/Header` in seconds."""
    return to_ns(header.stamp) / NS


def scan_of(message: Any, lidar: LidarModel | None = None) -> Scan | None:
    """Translate a `sensor_msgs/LaserScan`; None without a measurement.

    That is: it has no rays, more than :data:`MOST_RAYS`, invalid angles or limits, or only rays
    that are NaN ("no measurement" of the LDS-02's driver) or 0 (of the LDS-01's). Inf is a
    measurement: nothing is there.

    The limits are the narrower ones of the message and of the robot's lidar, if it is given. Its
    mount turns the angles, so that 0 is ahead of the base.
    """
    if len(message.ranges) > MOST_RAYS or not _has_angles(message):
        return None
    ranges = np.asarray(message.ranges, dtype=np.float32)
    # NaN first: of it and a number, min and max return the first.
    nearest = max(message.range_min, lidar.min_range) if lidar else message.range_min
    farthest = min(message.range_max, lidar.max_range) if lidar else message.range_max
    if not np.logical_or.reduce(ranges > 0.0) or not nearest < farthest:
        return None
    return Scan(
        stamp_s=stamp_of(message.header),
        angle_min=message.angle_min + math.radians(lidar.yaw) if lidar else message.angle_min,
        angle_increment=message.angle_increment,
        range_min=nearest,
        range_max=farthest,
        ranges=ranges,
    )


def _has_angles(scan: Any) -> bool:
    """Return whether the rays of a `sensor_msgs/LaserScan` have different directions."""
    step, first = abs(scan.angle_increment), abs(scan.angle_min)
    return first <= math.tau and (
        LEAST_INCREMENT_RAD <= step <= math.pi or (step == 0.0 and len(scan.ranges) == 1)
    )


_ODOMETRY = (
    "header.stamp.sec",
    "header.stamp.nanosec",
    "pose.pose.position.x",
    "pose.pose.position.y",
    *(f"pose.pose.orientation.{axis}" for axis in "xyzw"),
    "twist.twist.linear.x",
    "twist.twist.linear.y",
    "twist.twist.angular.z",
)


def odometry_picker() -> Picker:
    """Return what picks from a serialized `nav_msgs/Odometry` what :func:`odometry_of` needs."""
    return Picker(decoder_of("nav_msgs/msg/Odometry"), _ODOMETRY)


def odometry_of(picked: Picked) -> OdometryMessage | None:
    """Translate a `nav_msgs/Odometry`; None for a number that is not finite."""
    sec, nanosec, x, y, qx, qy, qz, qw, linear, lateral, angular = picked.numbers
    pose = planar_pose(x, y, qx, qy, qz, qw)
    velocity = Twist2D(linear, angular, lateral)
    if pose is None or not velocity.is_finite:
        return None
    stamp_s = (sec * NS + nanosec) / NS
    return OdometryMessage(stamp_s, picked.texts["header.frame_id"], pose, velocity)


def speed_limit_of(message: Any, fastest: float) -> float | None:
    """Translate a `nav2_msgs/SpeedLimit` to m/s; `fastest` is the robot's highest speed.

    0 stands for no limit, as in Nav2. None for what is not a number of 0 or more.
    """
    limit = message.speed_limit * (fastest / 100.0 if message.percentage else 1.0)
    if not limit >= 0.0:
        return None
    return limit or math.inf


def pose_of(message: Any) -> Pose2D | None:
    """Translate a `geometry_msgs/Pose`; None for a number that is not finite."""
    return _pose(message.position, message.orientation)


def transform_of(message: Any) -> Pose2D | None:
    """Translate a `geometry_msgs/Transform`; None for a number that is not finite."""
    return _pose(message.translation, message.rotation)


def _pose(at: Any, rotation: Any) -> Pose2D | None:
    return planar_pose(at.x, at.y, rotation.x, rotation.y, rotation.z, rotation.w)


def planar_pose(x: float, y: float, qx: float, qy: float, qz: float, qw: float) -> Pose2D | None:
    """Return the pose on the floor of a place (m) and a quaternion; None if one is invalid."""
    yaw = yaw_about_z(qx, qy, qz, qw)
    # NaN compares false. Of infinite numbers, yaw may be finite.
    is_near = -FARTHEST_M <= x <= FARTHEST_M and -FARTHEST_M <= y <= FARTHEST_M
    return Pose2D(x, y, yaw) if is_near and math.isfinite(yaw + qx + qy + qz + qw) else None


MOST_JOINTS = 200


def joints_of(message: Any) -> JointReadings | None:
    """Translate a `sensor_msgs/JointState`; None without positions that are finite.

    Velocities and forces that it lacks are 0, and so are forces that are not finite: ros2_control
    sends NaN for what no motor measures.
    """
    names, positions = list(message.name), list(message.position)
    if not 0 < len(names) <= MOST_JOINTS or len(positions) != len(names):
        return None
    velocities = list(message.velocity) or [0.0] * len(names)
    efforts = list(message.effort) or [0.0] * len(names)
    if not len(velocities) == len(efforts) == len(names):
        return None
    if not all(map(math.isfinite, (*positions, *velocities))):
        return None
    return JointReadings(
        stamp_of(message.header),
        dict(zip(names, positions, strict=True)),
        dict(zip(names, velocities, strict=True)),
        {
            name: effort if math.isfinite(effort) else 0.0
            for name, effort in zip(names, efforts, strict=True)
        },
    )


def grid_of(message: Any) -> Grid | None:
    """Translate a `nav_msgs/OccupancyGrid`; None if its numbers are not a map.

    That is: its size and its cells do not agree, or resolution or origin are out of range.
    """
    info = message.info
    corner = info.origin.position
    cells = np.asarray(message.data, dtype=np.int8)
    if not cells.size or cells.size != info.height * info.width:
        return None
    if not LEAST_CELL_M <= info.resolution <= MOST_CELL_M:
        return None
    if not (abs(corner.x) <= FARTHEST_M and abs(corner.y) <= FARTHEST_M):
        return None
    return Grid(
        resolution=info.resolution,
        origin_x=corner.x,
        origin_y=corner.y,
        cells=cells.reshape(info.height, info.width),
        stamp=stamp_of(message.header),
    )


def image_of(message: Any) -> Image:
    """Translate a `sensor_msgs/Image`.

    Raises ValueError for an encoding other than rgb8, bgr8, rgba8, bgra8 and mono8, and for an
    image whose size does not match its data.
    """
    channels = _CHANNELS.get(message.encoding)
    if channels is None:
        known = ", ".join(_CHANNELS)
        raise ValueError(f"image encoding must be one of {known}, got '{message.encoding}'")
    data = np.frombuffer(message.data, dtype=np.uint8)
    height, width = message.height, message.width
    if message.step < width * channels or data.size != height * message.step or not data.size:
        raise ValueError(
            f"an image of {width} x {height} pixels, {message.encoding}, {message.step} bytes a "
            f"row, cannot have {data.size} bytes"
        )
    pixels = data.reshape(height, message.step)[:, : width * channels]
    return Image(
        stamp_s=stamp_of(message.header),
        height=height,
        width=width,
        rgb=_rgb(pixels.reshape(height, width, channels), message.encoding),
        frame=message.header.frame_id,
    )


def _rgb(pixels: npt.NDArray[np.uint8], encoding: str) -> npt.NDArray[np.uint8]:
    if encoding == "mono8":
        return np.repeat(pixels, 3, axis=2)
    colours = pixels[:, :, :3]
    return colours[:, :, ::-1] if encoding.startswith("bgr") else colours


def fill(message: Any, fields: Fields, now: Callable[[], Any]) -> Any:
    """Set fields of a message from plain values, and return it.

    A Pose2D fills a Pose, or a PoseStamped in the map frame at the time that `now` returns (a
    `builtin_interfaces/Time`); seconds fill a Duration or a Time; a mapping fills a nested message;
    bytes fill a sequence of uint8, and a sequence fills one of any of them. Raises AttributeError
    for an unknown field.
    """
    kind: Any = type(message)
    types = _types_of(kind)
    for name, value in fields.items():
        if name not in types:
            raise AttributeError(
                f"{type(message).__name__} has no field '{name}', only {', '.join(types)}"
            )
        type_name = types[name]
        setattr(
            message,
            name,
            float(value) if type_name in _NUMBERS else _filled(type_name, value, now),  # type: ignore[arg-type]
        )
    return message


@cache
def _types_of(kind: Any) -> Mapping[str, str]:
    types: Mapping[str, str] = kind.get_fields_and_field_types()  # a copy each time
    return types


def _filled(type_name: str, value: Any, now: Callable[[], Any]) -> Any:
    if type_name in _NUMBERS:
        return float(value)
    if isinstance(value, bytes):
        return array("B", value)  # ten thousand times faster than number by number
    if type_name.startswith(_SEQUENCE):
        element = type_name.removeprefix(_SEQUENCE).removesuffix(">")
        return [_filled(element, item, now) for item in value]
    if type_name in _TEXTS:
        return str(value)
    if "/" not in type_name:
        return bool(value) if type_name == "boolean" else int(value)
    message = _made(type_name)
    if type_name == "geometry_msgs/PoseStamped":
        message.header.frame_id = MAP_FRAME
        message.header.stamp = now()
        set_planar(message.pose.position, message.pose.orientation, value)
    elif type_name == "geometry_msgs/Pose":
        set_planar(message.position, message.orientation, value)
    elif type_name in _TIMES:
        set_ns(message, round(value * NS))
    else:
        fill(message, value, now)
    return message


def _made(type_name: str) -> Any:
    package, name = type_name.split("/")
    return generated_type(f"{package}/msg/{name}")()


def generated_type(name: str) -> Any:
    """Return the class of a type, such as "nav2_msgs/action/Spin"."""
    package, folder, type_name = name.split("/")
    return getattr(importlib.import_module(f"{package}.{folder}"), type_name)


_RAYS = 720

_Geometry: TypeAlias = tuple[int, float, float, float, float]
"""The number of rays, the first angle and the step, rad, and the limits of ranges, m."""


@dataclass(frozen=True, slots=True)
class _ScanRays:
    """The rays of all lidars: limits of ranges, directions and origins, m from the first lidar."""

    least: npt.NDArray[np.float32]
    most: npt.NDArray[np.float32]
    towards: npt.NDArray[np.complex128]
    origins: npt.NDArray[np.complex128]


class ScanMerger:
    """Merges the scans of the lidars of a robot, whose angles are from ahead of the base."""

    def __init__(self, lidars: Sequence[LidarModel]) -> None:
        self._lidars = lidars
        self._scans: Sequence[Scan | None] = ()
        self._merged: Scan | None = None
        self._geometries: tuple[_Geometry, ...] = ()
        first = lidars[0]
        self._farthest = max(
            lidar.max_range + math.hypot(lidar.x - first.x, lidar.y - first.y) for lidar in lidars
        )

    def merged(self, scans: Sequence[Scan | None]) -> Scan | None:
        """Return the scan of all; None until each lidar has measured.

        The same object is returned until one of the scans is newer.
        """
        known = self._scans
        if len(known) != len(scans) or any(a is not b for a, b in zip(scans, known, strict=True)):
            self._scans = tuple(scans)
            self._merged = self._merge([scan for scan in scans if scan is not None])
        return self._merged

    def _merge(self, scans: list[Scan]) -> Scan | None:
        if len(scans) < len(self._lidars):
            return None
        ranges = np.concatenate([scan.ranges for scan in scans])
        rays = self._rays_of(tuple(map(_geometry, scans)))
        with np.errstate(invalid="ignore"):
            is_hit = (ranges >= rays.least) & (ranges <= rays.most)
        is_valid = is_hit | np.isinf(ranges)
        ends = rays.towards * np.fmin(ranges, rays.most) + rays.origins
        step = math.tau / _RAYS
        # From -360 to 360; the negative ones count from the end of the merged scan.
        bins = np.rint(np.arctan2(ends.imag, ends.real) / step).astype(np.intp)
        reach = np.where(is_hit, np.abs(ends), np.inf)
        if not is_valid.all():
            bins, reach = bins[is_valid], reach[is_valid]
        # NaN: nobody has measured there. Inf: somebody has, and nothing is there.
        merged = np.full(_RAYS, np.nan)
        merged[bins] = np.inf
        np.minimum.at(merged, bins, reach)
        return Scan(
            stamp_s=min(scan.stamp_s for scan in scans),
            angle_min=0.0,
            angle_increment=step,
            range_min=min(scan.range_min for scan in scans),
            range_max=self._farthest,
            ranges=merged.astype(np.float32),
        )

    def _rays_of(self, geometries: tuple[_Geometry, ...]) -> _ScanRays:
        """Return the rays of scans; the same object while no geometry changes."""
        if geometries != self._geometries:
            first = self._lidars[0]
            least, most, towards, origins = [], [], [], []
            for (count, angle, step, nearest, farthest), lidar in zip(
                geometries, self._lidars, strict=True
            ):
                least.append(np.full(count, nearest, dtype=np.float32))
                most.append(np.full(count, farthest, dtype=np.float32))
                towards.append(np.exp(1j * (angle + step * np.arange(count))))
                origins.append(np.full(count, complex(lidar.x - first.x, lidar.y - first.y)))
            self._rays = _ScanRays(*map(np.concatenate, (least, most, towards, origins)))
            self._geometries = geometries
        return self._rays


def _geometry(scan: Scan) -> _Geometry:
    count = len(scan.ranges)
    return count, scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max
