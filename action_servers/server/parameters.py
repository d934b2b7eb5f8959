"""The parameters of the servers' node whose defaults and limits depend on the robot."""

from __future__ import annotations

from pathlib import Path

from bt_mission.base.parameters import ParameterSpec
from bt_mission.robots.model import RobotModel
from bt_mission.ros.executors.process import RobotNode

SLOWEST_CONTROL_HZ, FASTEST_CONTROL_HZ = 5.0, 100.0
LOWEST_LINEAR, LOWEST_ANGULAR = 0.05, 0.1

ON_NEW_GOAL = ParameterSpec(
    "replace",
    "What a goal does that comes while another one drives: replace it, which ends aborted, or be "
    "refused itself.",
    choices=("replace", "refuse"),
)


def limited(node: RobotNode, robot: RobotModel) -> RobotModel:
    """Declare the rate of control and the highest speeds; return the robot within them.

    Raises:
        rclpy.exceptions.ParameterException: For a limit out of its range.
    """
    linear, angular = robot.max_linear_velocity, robot.max_angular_velocity
    limits = {
        "control_rate": ParameterSpec(
            robot.control_rate,
            "Control steps and commands a second, Hz.",
            SLOWEST_CONTROL_HZ,
            FASTEST_CONTROL_HZ,
        ),
        "max_linear_velocity": ParameterSpec(
            linear,
            "Fastest that is commanded, m/s; at most what the robot's model says.",
            min(LOWEST_LINEAR, linear),
            linear,
        ),
        "max_angular_velocity": ParameterSpec(
            angular,
            "Fastest turn that is commanded, rad/s; at most what the robot's model says.",
            min(LOWEST_ANGULAR, angular),
            angular,
        ),
    }
    return robot.model_copy(
        update={name: node.declare(name, spec) for name, spec in limits.items()}
    )


def declare_server_parameters(node: RobotNode, robot: RobotModel, image_folder: Path) -> None:
    """Declare what the node was started with, to be looked at."""
    node.declare(
        "robot", ParameterSpec(robot.name, "Model of the robot: limits, hull and sensors.")
    )
    node.declare(
        "image_folder",
        ParameterSpec(
            str(image_folder), "Where images are stored, those of each goal in a folder."
        ),
    )
