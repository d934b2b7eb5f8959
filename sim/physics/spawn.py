"""The robots of one simulation, each with a name and a start."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from bt_mission.base.errors import BtMissionError
from bt_mission.robots.model import RobotModel, load_robot
from sim.world.world import Spawn

MOST = 16
"""Robots in one world: MuJoCo can switch off the motors of 31 groups of actuators."""

NAME = re.compile("[a-z][a-z0-9_]{0,39}")
"""The form of a robot's name."""
_PLACE = ("x", "y", "yaw")
_NUMBER = r"([+-]?(?:\d+\.?\d*|\.\d+))"
_WRITTEN = re.compile(rf"([^=@]+)=([^@]+)(?:@{_NUMBER},{_NUMBER}(?:,{_NUMBER})?)?")
_EXPECTED = (
    "expected a robot as NAME=MODEL@X,Y,YAW in metres and degrees, such as one=waffle@-1,0,90, "
)


class RobotSpawnError(BtMissionError):
    """Robots that cannot be in one world under their names."""

    code = "BT-803"


@dataclass(frozen=True)
class RobotSpawn:
    """A robot: its model, its name, and its start (None: the world's spawn).

    The name is also the namespace of its topics. A robot alone needs none.
    """

    robot: RobotModel
    name: str = ""
    spawn: Spawn | None = None

    @property
    def prefix(self) -> str:
        """The prefix of the names of its parts and topics."""
        return f"{self.name}/" if self.name else ""


def read(text: str) -> RobotSpawn:
    """Read a robot written as `NAME=MODEL@X,Y,YAW` (m, m, degrees), such as `one=waffle@-1,0,90`.

    MODEL is a robot's name or file; the yaw, or the whole place, is optional. Raises
    RobotSpawnError, and InputError for an invalid model.
    """
    written = _WRITTEN.fullmatch(text)
    if written is None:
        raise RobotSpawnError(_EXPECTED + f"got '{text}'")
    name, model, *place = written.groups()
    given = {field: float(number) for field, number in zip(_PLACE, place, strict=True) if number}
    try:
        spawn = Spawn(**given) if given else None
    except ValueError as error:
        raise RobotSpawnError(_EXPECTED + f"within the world, got '{text}'") from error
    return RobotSpawn(load_robot(model), name, spawn)


def check(entrants: Sequence[RobotSpawn]) -> None:
    """Raise RobotSpawnError unless there are robots, and several have different names."""
    if not 1 <= len(entrants) <= MOST:
        raise RobotSpawnError(f"expected 1 to {MOST} robots in a world, got {len(entrants)}")
    seen: set[str] = set()
    for entrant in entrants:
        name = entrant.name
        if len(entrants) == 1 and not name:
            return
        if not NAME.fullmatch(name):
            raise RobotSpawnError(
                f"expected a name of small letters, digits and '_', such as robot1, got '{name}':"
                " a robot's name is the namespace of its topics"
            )
        if name in seen:
            raise RobotSpawnError(f"two robots are named '{name}'; give each its own name")
        seen.add(name)
