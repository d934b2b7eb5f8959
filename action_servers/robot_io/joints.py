"""The commands from the servers to the joints of arm and gripper."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.node import Node
from sensor_msgs.msg import JointState

from bt_mission.robots.model import RobotModel


class JointCommander:
    """Publishes positions for joints on `joint_commands`, as topic_based_ros2_control does.

    A robot without such joints has no topic.
    """

    def __init__(self, node: Node, robot: RobotModel) -> None:
        self._clock = node.get_clock()
        self._context = node.context
        self._publisher = (
            node.create_publisher(JointState, "joint_commands", 10) if robot.moved_joints else None
        )

    def send(
        self, names: Sequence[str], positions: Sequence[float], efforts: Sequence[float] = ()
    ) -> None:
        """Send joints to positions, rad or m, with at most these forces, N or N m."""
        if self._publisher is None or not self._context.ok():
            return
        message = JointState(
            name=list(names), position=list(positions), effort=[float(each) for each in efforts]
        )
        message.header.stamp = self._clock.now().to_msg()
        self._publisher.publish(message)
