"""The simulator in AMCL's place: programs for Nav2 wait for it before they send goals."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped
from lifecycle_msgs.msg import State
from lifecycle_msgs.srv import GetState
from rclpy.node import Node

from bt_mission.base.geometry import Pose2D, set_planar
from sim import frames
from sim.robot.robot import SimulatedRobot
from sim.ros.message_fields import header
from sim.ros.schedule import Schedule
from sim.ros.sensor_topics import LATCHED
from sim.ros.topics import REQUESTS

RATE_HZ = 2.0


def localise(node: Node, schedule: Schedule, stamp: Any, robot: SimulatedRobot) -> None:
    """Publish a robot's pose by its localization as `amcl_pose`; its node's state is "active"."""
    message = header(PoseWithCovarianceStamped(), stamp, frames.MAP)
    place = message.pose.pose
    publisher = node.create_publisher(type(message), f"{robot.prefix}amcl_pose", LATCHED)

    def publish(_: int) -> None:
        reading = robot.read_odometry()
        believed = robot.localization.believed(robot.pose, (reading.x, reading.y, reading.yaw))
        set_planar(place.position, place.orientation, Pose2D(*believed))
        publisher.publish(message)

    def answer(_request: Any, response: Any) -> Any:
        response.current_state.id = State.PRIMARY_STATE_ACTIVE
        response.current_state.label = "active"
        return response

    schedule.every(RATE_HZ, "amcl_pose", publish)
    name = f"{robot.prefix}amcl/get_state"
    node.create_service(GetState, name, answer, qos_profile=REQUESTS)
