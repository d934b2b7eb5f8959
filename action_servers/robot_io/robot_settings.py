"""What differs from robot to robot beside its model: topics, frames, rates and limits.

Each setting is a ROS parameter of the servers' node, with description and range. The defaults are
those of a TurtleBot3 on Jazzy and of the robot's model.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from action_servers.robot_io.command_types import CHOICES, Choice
from bt_mission.core.robot.model import RobotModel

SLOWEST_CONTROL_HZ = 5.0
FASTEST_CONTROL_HZ = 100.0
LOWEST_LINEAR = 0.05
LOWEST_ANGULAR = 0.1


@dataclass(frozen=True, slots=True)
class Setting:
    """One parameter: a text, or a number from `low` to `high`."""

    name: str
    default: str | float
    description: str
    low: float = 0.0
    high: float = 0.0
    choices: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class RobotTopics:
    """Names of the robot's topics, relative to the namespace unless they begin with a slash."""

    cmd_vel: str = "cmd_vel"
    scan: str = "scan"
    odom: str = "odom"
    tf: str = "tf"
    map: str = "map"
    camera: str = "camera/image_raw"


@dataclass(frozen=True, slots=True)
class Wiring:
    """How the servers are joined to a robot."""

    topics: RobotTopics = RobotTopics()
    base_frame: str = "base_footprint"
    map_frame: str = "map"
    command_type: Choice = "stamped"
    watched: bool = False
    """Whether to look who listens to commands, and refuse goals while nobody would hear."""


_TOPICS = {
    "cmd_vel": "Velocity commands, geometry_msgs/TwistStamped or Twist.",
    "scan": "The lidar, sensor_msgs/LaserScan.",
    "odom": "Odometry, nav_msgs/Odometry.",
    "tf": "Transforms; the one from the map to the odometry frame is read.",
    "map": "The map, nav_msgs/OccupancyGrid.",
    "camera": "Pictures, sensor_msgs/Image.",
}


def base_settings(command_type: Choice) -> tuple[Setting, ...]:
    """Return the settings of whatever commands a base."""
    return (
        Setting("topics.cmd_vel", RobotTopics().cmd_vel, _TOPICS["cmd_vel"]),
        Setting("frames.base", Wiring().base_frame, "Frame id of stamped velocity commands."),
        Setting(
            "cmd_vel_type",
            command_type,
            "stamped, plain, or auto: what the robot is found to listen for.",
            choices=CHOICES,
        ),
    )


def sensor_settings() -> tuple[Setting, ...]:
    """Return the settings of whatever listens to a robot."""
    names = RobotTopics()
    return (
        *(
            Setting(f"topics.{key}", getattr(names, key), description)
            for key, description in _TOPICS.items()
            if key != "cmd_vel"
        ),
        Setting("frames.map", Wiring().map_frame, "Frame of the map, in transforms."),
    )


def settings(robot: RobotModel, command_type: Choice) -> tuple[Setting, ...]:
    """Return every setting, with its default for this robot."""
    linear, angular = robot.max_linear_velocity, robot.max_angular_velocity
    return (
        *sensor_settings(),
        *base_settings(command_type),
        Setting(
            "control_rate",
            robot.control_rate,
            "Control steps and commands a second, Hz.",
            SLOWEST_CONTROL_HZ,
            FASTEST_CONTROL_HZ,
        ),
        Setting(
            "max_linear_velocity",
            linear,
            "Fastest that is commanded, m/s; at most what the robot's model says.",
            min(LOWEST_LINEAR, linear),
            linear,
        ),
        Setting(
            "max_angular_velocity",
            angular,
            "Fastest turn that is commanded, rad/s; at most what the robot's model says.",
            min(LOWEST_ANGULAR, angular),
            angular,
        ),
    )


def fault(setting: Setting, value: object) -> str | None:
    """Return why a value does not suit a setting, or None."""
    if isinstance(setting.default, str):
        if not isinstance(value, str) or not value:
            return f"{setting.name} must be a text, got {value!r}"
        if setting.choices and value not in setting.choices:
            return f"{setting.name} must be one of {', '.join(setting.choices)}, got '{value}'"
        return None
    if isinstance(value, bool) or not isinstance(value, int | float):
        return f"{setting.name} must be a number, got {value!r}"
    if not setting.low <= value <= setting.high:
        return f"{setting.name} must be from {setting.low:g} to {setting.high:g}, got {value:g}"
    return None


def applied(
    robot: RobotModel, values: Mapping[str, Any], *, watched: bool
) -> tuple[RobotModel, Wiring]:
    """Return the robot within its lowered limits, and its wiring, from all settings' values."""
    limited = {
        name: float(values[name])
        for name in ("control_rate", "max_linear_velocity", "max_angular_velocity")
    }
    wiring = replace(
        listening(values),
        base_frame=values["frames.base"],
        command_type=values["cmd_vel_type"],
        watched=watched,
    )
    return robot.model_copy(update=limited), wiring


def listening(values: Mapping[str, Any]) -> Wiring:
    """Return the wiring of what only listens, from the values of the sensors' settings at least."""
    topics = {key: values[f"topics.{key}"] for key in _TOPICS if f"topics.{key}" in values}
    return Wiring(RobotTopics(**topics), map_frame=values["frames.map"])
