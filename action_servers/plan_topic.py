"""The path that is being driven, as Nav2 publishes it: for RViz and Foxglove."""

from __future__ import annotations

from typing import TYPE_CHECKING

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path

from action_servers.navigation.grid import Floats

if TYPE_CHECKING:
    from rclpy.node import Node

FRAME = "map"


class PlanTopic:
    """Publishes `plan`, where somebody subscribes to it."""

    def __init__(self, node: Node) -> None:
        self._clock = node.get_clock()
        self._publisher = node.create_publisher(Path, "plan", 1)

    def publish(self, points: Floats) -> None:
        """Publish a path: points in the map, `n x 2` m."""
        if not self._publisher.get_subscription_count():
            return
        path = Path()
        path.header.frame_id = FRAME
        path.header.stamp = self._clock.now().to_msg()
        for x, y in points.tolist():
            pose = PoseStamped(header=path.header)
            pose.pose.position.x, pose.pose.position.y = x, y
            path.poses.append(pose)
        self._publisher.publish(path)
