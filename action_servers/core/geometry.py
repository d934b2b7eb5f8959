"""Plane geometry of poses and points."""

from __future__ import annotations

import math

import numpy as np

from action_servers.core.grid import Floats
from action_servers.core.maneuver import Pose2D


def wrapped(angle: float) -> float:
    """Return an angle in radians as one in [-pi, pi]."""
    return math.remainder(angle, math.tau)


def distance(a: Pose2D, b: Pose2D) -> float:
    """Return the distance between two poses in metres."""
    return math.hypot(b.x - a.x, b.y - a.y)


def into_frame(pose: Pose2D, points: Floats) -> Floats:
    """Return `n x 2` points, given in the frame in which `pose` is, as seen from `pose`."""
    cosine, sine = math.cos(pose.yaw), math.sin(pose.yaw)
    across, along = points[:, 0] - pose.x, points[:, 1] - pose.y
    return np.column_stack((cosine * across + sine * along, cosine * along - sine * across))


def out_of_frame(pose: Pose2D, points: Floats) -> Floats:
    """Return `n x 2` points, as seen from `pose`, in the frame in which `pose` is given."""
    cosine, sine = math.cos(pose.yaw), math.sin(pose.yaw)
    forward, left = points[:, 0], points[:, 1]
    return np.column_stack(
        (pose.x + cosine * forward - sine * left, pose.y + sine * forward + cosine * left)
    )


def composed(outer: Pose2D, inner: Pose2D) -> Pose2D:
    """Return the pose `inner`, given relative to `outer`, in the frame of `outer`."""
    cosine, sine = math.cos(outer.yaw), math.sin(outer.yaw)
    return Pose2D(
        outer.x + cosine * inner.x - sine * inner.y,
        outer.y + sine * inner.x + cosine * inner.y,
        wrapped(outer.yaw + inner.yaw),
    )


def relative(outer: Pose2D, pose: Pose2D) -> Pose2D:
    """Return `pose` as seen from `outer`; both are given in one frame."""
    cosine, sine = math.cos(outer.yaw), math.sin(outer.yaw)
    across, along = pose.x - outer.x, pose.y - outer.y
    return Pose2D(
        cosine * across + sine * along,
        cosine * along - sine * across,
        wrapped(pose.yaw - outer.yaw),
    )


def between(first: Pose2D, second: Pose2D, fraction: float) -> Pose2D:
    """Return the pose at a fraction of the way from one pose to another, the short way round."""
    return Pose2D(
        first.x + fraction * (second.x - first.x),
        first.y + fraction * (second.y - first.y),
        wrapped(first.yaw + fraction * wrapped(second.yaw - first.yaw)),
    )
