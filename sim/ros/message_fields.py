"""Writes readings into ROS messages, which are handed in."""

from __future__ import annotations

import math
from typing import Any

from bt_mission.base.stamps import set_ns
from sim.frames import MAP, FramePose
from sim.physics.contacts import Collision


def header(message: Any, stamp: Any, frame: str, child: str | None = None) -> Any:
    """Give a message its frames, and a stamp that others may share. Return the message."""
    message.header.stamp, message.header.frame_id = stamp, frame
    if child is not None:
        message.child_frame_id = child
    return message


def transform(message: Any, frame: FramePose, stamp: Any) -> Any:
    """Fill a TransformStamped with a fixed frame, and return it."""
    header(message, stamp, frame.parent, frame.child)
    t, r = message.transform.translation, message.transform.rotation
    t.x, t.y, t.z = frame.translation
    r.x, r.y, r.z, r.w = frame.rotation
    return message


def collision(message: Any, event: Collision) -> Any:
    """Fill a Collision, with its own time as the stamp, and return it."""
    set_ns(message.header.stamp, event.time_ns)
    message.header.frame_id = MAP
    message.obstacle, message.force = event.obstacle, event.force
    message.point.x, message.point.y, message.point.z = event.point
    return message


def planar(x: float, y: float, yaw: float) -> tuple[float, float, float, float]:
    """Return x and y of a place, and z and w of its quaternion."""
    return x, y, math.sin(yaw / 2.0), math.cos(yaw / 2.0)
