"""The poses to which a goal sends the robot."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from bt_mission.base.geometry import yaw_of

MOST = 1000
"""The number of poses of a goal that are read."""


@dataclass(frozen=True)
class NamedPose:
    """A pose that a goal names: m, m, rad, in a frame."""

    x: float
    y: float
    yaw: float
    frame: str


def poses_of(request: Any) -> list[NamedPose]:
    """Return the stamped poses among a goal's fields in their order, including those in lists.

    Args:
        request: A goal message of any type.
    """
    return list(_poses_in(request))[:MOST]


def _poses_in(request: Any) -> Iterator[NamedPose]:
    fields: dict[str, str] = getattr(request, "get_fields_and_field_types", dict)()
    for name, type_name in fields.items():
        if "geometry_msgs/PoseStamped" in type_name:
            value = getattr(request, name)
            stamped = value if isinstance(value, list | tuple) else [value]
            yield from map(_place, stamped[:MOST])


def _place(stamped: Any) -> NamedPose:
    at, turn = stamped.pose.position, stamped.pose.orientation
    return NamedPose(at.x, at.y, yaw_of(turn), stamped.header.frame_id)
