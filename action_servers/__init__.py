"""Action servers of the robot: pure maneuvers, the pilot that owns the base, one adapter to ROS.

The names of `__all__` are public: with them a user writes an action, and serves it beside ours.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from bt_mission.base.lazy import lazy_names

if TYPE_CHECKING:
    from action_servers.core.action import Action
    from action_servers.core.limits import ChoiceLimit, NumberLimit, outside
    from action_servers.core.maneuver import (
        SUCCEEDED,
        ZERO,
        ErrorCode,
        Finished,
        Grid,
        Image,
        Maneuver,
        Observation,
        Refusal,
        Scan,
        refusal,
        stale,
    )
    from action_servers.core.tuning import Tuning
    from action_servers.driving.drive import Drive
    from action_servers.server.node import ServerOptions, ServersNode
    from bt_mission.base.geometry import Pose2D, Twist2D
    from bt_mission.robots.model import RobotModel, load_robot

__all__ = [
    "SUCCEEDED",
    "ZERO",
    "Action",
    "ChoiceLimit",
    "Drive",
    "ErrorCode",
    "Finished",
    "Grid",
    "Image",
    "Maneuver",
    "NumberLimit",
    "Observation",
    "Pose2D",
    "Refusal",
    "RobotModel",
    "Scan",
    "ServerOptions",
    "ServersNode",
    "Tuning",
    "Twist2D",
    "load_robot",
    "outside",
    "refusal",
    "stale",
]

__getattr__ = lazy_names(
    __name__,
    {
        **dict.fromkeys(__all__, "action_servers.core.maneuver"),
        "Action": "action_servers.core.action",
        **dict.fromkeys(("refusal", "stale"), "action_servers.core.maneuver"),
        **dict.fromkeys(("ServerOptions", "ServersNode"), "action_servers.server.node"),
        **dict.fromkeys(("Pose2D", "Twist2D"), "bt_mission.base.geometry"),
        **dict.fromkeys(("RobotModel", "load_robot"), "bt_mission.robots.model"),
        "Drive": "action_servers.driving.drive",
        "ErrorCode": "action_servers.core.maneuver",
        "Tuning": "action_servers.core.tuning",
        **dict.fromkeys(("ChoiceLimit", "NumberLimit", "outside"), "action_servers.core.limits"),
    },
)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
