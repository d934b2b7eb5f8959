"""The path that is being driven, as Nav2 publishes it: for RViz and Foxglove."""

from __future__ import annotations

from typing import TYPE_CHECKING

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from rclpy.qos import DurabilityPolicy, QoSProfile

from action_servers.core.grid import Floats

if TYPE_CHECKING:
    from rclpy.node import Node

FRAME = "map"


LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class PlanTopic:
    """Publishes `plan`, latched: who opens RViz later sees the path, too.

    :param lean: only while somebody subscribes to it.
    """

    def __init__(self, node: Node, *, lean: bool) -> None:
        self._lean = lean
        self._clock = node.get_clock()
        self._publisher = node.create_publisher(Path, "plan", LATCHED)

    def publish(self, points: Floats) -> None:
        """Publish a path: points in the map, `n x 2` m."""
        if self._lean and not self._publisher.get_subscription_count():
            return
        path = Path()
        path.header.frame_id = FRAME
        path.header.stamp = self._clock.now().to_msg()
        for x, y in points.tolist():
            pose = PoseStamped(header=path.header)
            pose.pose.position.x, pose.pose.position.y = x, y
            path.poses.append(pose)
        self._publisher.publish(path)
