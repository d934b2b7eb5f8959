"""What people see of a robot's body, as plain shapes in `base_link`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from bt_mission.core.robot.model import RobotModel

Triple = tuple[float, float, float]


@dataclass(frozen=True)
class LookShape:
    """A box of half edges, or an upright cylinder of radius and half height (and 0), m."""

    kind: Literal["box", "cylinder"]
    half: Triple
    at: Triple
    colour: str


def looks(robot: RobotModel) -> list[LookShape]:
    """Return plates, a core, the lidar, and a bar in front."""
    length, width, height = robot.body.size
    x, y, z = robot.body.centre
    plate = 0.004
    plates = [
        LookShape(
            "box",
            (length / 2, width / 2, plate),
            (x, y, z + level * (height / 2 - plate)),
            "#3a3f44",
        )
        for level in (-1, 0, 1)
    ]
    core = (length * 0.42, width * 0.36, height / 2 - 2 * plate)
    lidar = (robot.lidar.x, robot.lidar.y, robot.lidar.z - 0.005)
    bar = (robot.hull.front - 0.012, 0.0, z + height / 2)
    return [
        *plates,
        LookShape("box", core, (x, y, z), "#5b6570"),
        LookShape("cylinder", (0.035, 0.02, 0.0), lidar, "black"),
        LookShape("box", (0.006, width / 4, 0.006), bar, "orange"),
    ]
