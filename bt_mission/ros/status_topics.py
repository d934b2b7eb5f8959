"""What tools see of a running mission: its tree once, and after that what changes.

``~/tree`` and ``~/state`` are latched; ``~/changes`` carries the changes of one tick, and nothing
is sent for a tick that changes nothing. Who comes late asks ``~/statuses`` for all statuses at
once, and goes on from its sequence number.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bt_mission_interfaces.msg import MissionState, StatusChanges, Tree
from bt_mission_interfaces.srv import GetStatuses
from rclpy.qos import DurabilityPolicy, QoSProfile

from bt_mission.ros.detail_topics import DetailTopics

if TYPE_CHECKING:
    from rclpy.node import Node

    from bt_mission.ros.mission_run import MissionRun
    from bt_mission.ros.status_publisher import StatusFeed

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
CHANGES = QoSProfile(depth=100)


class StatusTopics:
    """Publishes what a feed tells, and the details beyond it.

    :param node: owns the topics; their names begin with its own.
    :param feed: tells of the missions; the topics flush it.
    """

    def __init__(self, node: Node, feed: StatusFeed) -> None:
        self._feed = feed
        self._publishers = {
            "tree": node.create_publisher(Tree, "~/tree", LATCHED),
            "state": node.create_publisher(MissionState, "~/state", LATCHED),
            "changes": node.create_publisher(StatusChanges, "~/changes", CHANGES),
        }
        self._details = DetailTopics(node)
        node.create_service(GetStatuses, "~/statuses", self._answer)
        feed.add(lambda what, message: self._publishers[what].publish(message))

    def begin(self, mission: MissionRun) -> None:
        """Follow the details of a mission, of which the feed tells already."""
        self._details.begin(self._feed.run, mission, self._feed.indices)

    def flush(self) -> None:
        """Publish what has changed since the last time, if anything has; at first the tree."""
        has_turned = self._feed.turn()
        self._details.flush(at_once=has_turned)

    def _answer(self, _request: Any, answer: Any) -> Any:
        self.flush()
        answer.run, answer.sequence = self._feed.run, self._feed.sequence
        answer.statuses = self._feed.statuses
        return answer
