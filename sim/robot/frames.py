"""The robot's frames as its URDF has them."""

from __future__ import annotations

import math

from bt_mission.core.robot.model import RobotModel
from sim.frames import BASE_FOOTPRINT, BASE_LINK, FramePose, Quaternion, Vector
from sim.sensors.kinds import sensors_of

WHEEL_JOINTS = ("wheel_left_joint", "wheel_right_joint")

# A quarter turn about x to the right: z along the axle to the left.
_SIDEWAYS: Quaternion = (-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))


def fixed_frames(robot: RobotModel) -> list[FramePose]:
    """Return all frames below `base_footprint`. Wheels are shown as at the start."""
    axle_z = robot.wheel_radius - robot.base_height
    return [
        FramePose(BASE_FOOTPRINT, BASE_LINK, (0.0, 0.0, robot.base_height)),
        FramePose(BASE_LINK, "wheel_left_link", (0.0, robot.wheel_y, axle_z), _SIDEWAYS),
        FramePose(BASE_LINK, "wheel_right_link", (0.0, -robot.wheel_y, axle_z), _SIDEWAYS),
        *(FramePose(BASE_LINK, _caster(at), at, _SIDEWAYS) for at in robot.casters),
        *(frame for kind in sensors_of(robot) for frame in kind.frames(robot)),
    ]


def _caster(at: Vector) -> str:
    side = "_left" if at[1] > 0 else "_right" if at[1] < 0 else ""
    return f"caster_back{side}_link"
