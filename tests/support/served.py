"""Every action that we serve, from its declaration: its type, a valid goal, and invalid ones."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

from builtin_interfaces.msg import Duration

from action_servers.core.action import Action, action
from action_servers.core.limits import ChoiceLimit, Limit, NumberLimit
from action_servers.joints.trajectory import JointsLimit
from action_servers.robot_io.messages import generated_type
from bt_mission.base.actions import declared
from bt_mission.robots.model import RobotModel
from bt_mission.ros.interface_types import fill

HUGE = 3.0e38
NOT_FINITE = (math.nan, math.inf, -math.inf)
LEAST, MOST = -(2**31), 2**31 - 1
TOPICS = {
    "scan": "scan",
    "odometry": "odom",
    "camera": "camera",
    **dict.fromkeys(("arm", "gripper"), "joint_states"),
}


@dataclass(frozen=True)
class Served:
    """One action; its example takes several seconds.

    `watches` are the topics whose silence ends a goal, `asks` those without which none is accepted.
    """

    action: Action
    type: Any

    @property
    def drives(self) -> bool:
        """Whether it drives."""
        return self.action.moves_base

    @property
    def is_alone(self) -> bool:
        """Whether one goal at a time runs: it moves the base, or another part."""
        return self.drives or bool(self.action.part)

    @property
    def watches(self) -> tuple[str, ...]:
        """What it needs, as topics."""
        return tuple(TOPICS[need] for need in self.action.needs if need in TOPICS)

    @property
    def asks(self) -> tuple[str, ...]:
        """A camera only sends pictures when asked, and what waits asks for nothing."""
        return (
            ()
            if self.action.waits
            else tuple(sensor for sensor in self.watches if sensor != "camera")
        )

    def limits(self, robot: RobotModel) -> tuple[Limit, ...]:
        """Return the limits of its goals for a robot."""
        return self.action.limits_with(robot)

    @property
    def poses(self) -> dict[str, str]:
        """The fields of its goals that hold poses, with their types."""
        fields = self.type.Goal.get_fields_and_field_types()
        return {field: kind for field, kind in fields.items() if "PoseStamped" in kind}

    def bad_goals(self, robot: RobotModel) -> Iterator[Any]:
        """Yield goals that are rejected, each for one value of one field."""
        valid = fill(self.type.Goal(), self.action.example)
        for limit in self.limits(robot):
            parent, _, name = limit.field.rpartition(".")
            for value in _outside(limit, attrgetter(limit.field)(valid)):
                bad = copy.deepcopy(valid)
                setattr(attrgetter(parent)(bad) if parent else bad, name, value)
                yield bad


def _outside(limit: Limit, valid: Any) -> tuple[Any, ...]:
    """Return values that a limit excludes, of the type of a valid one."""
    if isinstance(limit, ChoiceLimit):
        return ("", "bleu", "x" * 10_000)
    if isinstance(limit, JointsLimit):
        return [], ["elbow"], [*valid, valid[0]], [*valid, "elbow"]
    assert isinstance(limit, NumberLimit)
    if isinstance(valid, Duration):
        return Duration(sec=-1), Duration(sec=LEAST)
    if isinstance(valid, int):
        return math.ceil(limit.low) - 1, math.floor(limit.high) + 1, MOST, LEAST
    below = limit.low if limit.above else limit.low - 0.01 * abs(limit.low or 1.0)
    return *NOT_FINITE, HUGE, -HUGE, below, limit.high + 0.01 * abs(limit.high)


def _served(name: str) -> Served:
    served_action = action(name)
    return Served(served_action, generated_type(served_action.type))


SERVED = {name: _served(name) for name in declared()}
DRIVING = [name for name, served in SERVED.items() if served.drives]
BESIDE = [name for name, served in SERVED.items() if not served.is_alone]
OF_PARTS = [name for name, served in SERVED.items() if served.action.part]


def goal(name: str, **changes: Any) -> Any:
    """A valid goal of an action that takes several seconds, with changes."""
    message = fill(SERVED[name].type.Goal(), SERVED[name].action.example)
    for field, value in changes.items():
        setattr(message, field, value)
    return message
