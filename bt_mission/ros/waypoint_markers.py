"""The poses that a mission's goals name, as markers for RViz and Foxglove."""

from __future__ import annotations

from rclpy.node import Node
from visualization_msgs.msg import Marker, MarkerArray

from bt_mission.base.geometry import Pose2D, set_planar
from bt_mission.executive.events.events import GoalChanged
from bt_mission.executive.goals.poses import NamedPose
from bt_mission.ros.graph import LATCHED

MOST = 200
"""The number of poses that are shown; more would cover the map."""

_LENGTH, _TEXT = 0.25, 0.15
"""m: an arrow, and how high its number is written."""


class WaypointMarkers:
    """Publishes ``waypoints`` whenever a goal names a pose that none has named before.

    Args:
        node: The executive's node; the latched message has all poses so far.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publisher = node.create_publisher(MarkerArray, "waypoints", LATCHED)
        self._markers: dict[NamedPose, list[Marker]] = {}

    def close(self) -> None:
        """Destroy the publisher."""
        self._node.destroy_publisher(self._publisher)

    def take(self, event: GoalChanged) -> None:
        """Show the targets of a goal that is sent."""
        if event.change != "sent":
            return
        known = len(self._markers)
        for place in event.targets:
            if place not in self._markers and len(self._markers) < MOST:
                self._markers[place] = _shown(place, len(self._markers) + 1)
        if len(self._markers) > known:
            every = [marker for both in self._markers.values() for marker in both]
            self._publisher.publish(MarkerArray(markers=every))


def _shown(place: NamedPose, number: int) -> list[Marker]:
    """An arrow, and its number above it."""
    arrow = _marker(place, "waypoints", number, Marker.ARROW)
    arrow.scale.x, arrow.scale.y, arrow.scale.z = _LENGTH, 0.04, 0.04
    set_planar(arrow.pose.position, arrow.pose.orientation, Pose2D(place.x, place.y, place.yaw))
    arrow.color.r, arrow.color.g, arrow.color.b, arrow.color.a = 0.1, 0.4, 0.9, 1.0
    name = _marker(place, "waypoint numbers", number, Marker.TEXT_VIEW_FACING)
    name.text = str(number)
    name.pose.position.z = 2 * _TEXT
    name.scale.z = _TEXT
    name.color.r = name.color.g = name.color.b = name.color.a = 1.0
    return [arrow, name]


def _marker(place: NamedPose, namespace: str, number: int, kind: int) -> Marker:
    """A marker without a stamp: it stays with its frame."""
    marker = Marker(ns=namespace, id=number, type=kind)
    marker.header.frame_id = place.frame or "map"
    marker.pose.position.x, marker.pose.position.y = place.x, place.y
    return marker
