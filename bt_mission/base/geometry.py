"""Poses and velocities on the floor: metres, radians, m/s and rad/s; left is positive."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Pose2D:
    """Pose on the floor: `x`, `y` in metres, `yaw` in radians."""

    x: float
    y: float
    yaw: float


@dataclass(frozen=True, slots=True)
class Twist2D:
    """Velocity of the base: `linear` in m/s (forward is positive), `angular` in rad/s (left is).

    `lateral` in m/s, to the left, is only of bases that slide.
    """

    linear: float = 0.0
    angular: float = 0.0
    lateral: float = 0.0

    @property
    def is_finite(self) -> bool:
        """Whether it can be commanded: of NaN and a limit, `min` and `max` make full speed."""
        return math.isfinite(self.linear + self.angular + self.lateral)

    def __str__(self) -> str:
        aside = f", {self.lateral:g} m/s to the left" if self.lateral else ""
        return f"{self.linear:g} m/s, {self.angular:g} rad/s{aside}"


def wrap(angle: float) -> float:
    """Return an angle in radians as one in [-pi, pi]."""
    return math.remainder(angle, math.tau)


def yaw_of(q: Any) -> float:
    """Return the rotation about the vertical axis, rad, of a quaternion with x, y, z and w."""
    return yaw_about_z(q.x, q.y, q.z, q.w)


def yaw_about_z(x: float, y: float, z: float, w: float) -> float:
    """Return the rotation about the vertical axis, rad, of a quaternion.

    The formula also suits a quaternion that is not quite of unit length. NaN for numbers that are
    not finite, or whose squares are not.
    """
    try:
        return math.atan2(2.0 * (w * z + x * y), w**2 + x**2 - y**2 - z**2)
    except OverflowError:
        return math.nan


def set_planar(place: Any, rotation: Any, pose: Pose2D) -> None:
    """Set x and y of a point or vector message, and z and w of a quaternion message, to a pose."""
    place.x, place.y = pose.x, pose.y
    rotation.z, rotation.w = math.sin(pose.yaw / 2.0), math.cos(pose.yaw / 2.0)


def distance(a: Pose2D, b: Pose2D) -> float:
    """Return the distance between two poses in metres."""
    return math.hypot(b.x - a.x, b.y - a.y)


def composed(outer: Pose2D, inner: Pose2D) -> Pose2D:
    """Return the pose `inner`, given relative to `outer`, in the frame of `outer`."""
    cosine, sine = math.cos(outer.yaw), math.sin(outer.yaw)
    return Pose2D(
        outer.x + cosine * inner.x - sine * inner.y,
        outer.y + sine * inner.x + cosine * inner.y,
        wrap(outer.yaw + inner.yaw),
    )


def relative(outer: Pose2D, pose: Pose2D) -> Pose2D:
    """Return `pose` as seen from `outer`; both are in one frame."""
    cosine, sine = math.cos(outer.yaw), math.sin(outer.yaw)
    across, along = pose.x - outer.x, pose.y - outer.y
    return Pose2D(
        cosine * across + sine * along, cosine * along - sine * across, wrap(pose.yaw - outer.yaw)
    )


def between(first: Pose2D, second: Pose2D, fraction: float) -> Pose2D:
    """Return the pose at a fraction of the way between two poses, the short way round."""
    return Pose2D(
        first.x + fraction * (second.x - first.x),
        first.y + fraction * (second.y - first.y),
        wrap(first.yaw + fraction * wrap(second.yaw - first.yaw)),
    )
