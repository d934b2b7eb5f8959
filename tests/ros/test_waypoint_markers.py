"""Poses of goals as markers."""

from types import SimpleNamespace
from typing import Any

from visualization_msgs.msg import Marker

from bt_mission.events.events import GoalChanged
from bt_mission.goals.poses import NamedPose
from bt_mission.ros.waypoint_markers import MOST, WaypointMarkers


class Sent(list[Any]):
    """A node with one publisher, which keeps what is published."""

    def create_publisher(self, *_: Any) -> Any:
        return SimpleNamespace(publish=self.append)


def goal(*places: tuple[float, float], frame: str = "map", change: str = "sent") -> GoalChanged:
    """A goal with these targets."""
    targets = tuple(NamedPose(x, y, 0.0, frame) for x, y in places)
    return GoalChanged(1, "ab", "/go", "go", 1, "active", change, targets)


def test_each_pose_is_an_arrow_with_a_number() -> None:
    """In the frame that the goal names."""
    node: Any = Sent()
    WaypointMarkers(node).take(goal((1.0, 2.0), (3.0, 4.0), frame="odom"))
    arrow, number, _, second = node[-1].markers
    assert (arrow.type, arrow.header.frame_id) == (Marker.ARROW, "odom")
    assert (arrow.pose.position.x, arrow.pose.position.y) == (1.0, 2.0)
    assert (number.text, second.text) == ("1", "2")


def test_what_is_latched_tells_of_all() -> None:
    """A goal with a new pose adds it; one without says nothing."""
    node: Any = Sent()
    topic = WaypointMarkers(node)
    topic.take(goal((1.0, 2.0)))
    topic.take(goal((1.0, 2.0)))
    topic.take(goal((9.0, 9.0), change="ended"))
    topic.take(goal())
    topic.take(goal((3.0, 4.0)))
    assert [len(message.markers) for message in node] == [2, 4]


def test_poses_without_end_are_not_all_shown() -> None:
    """They would cover the map."""
    node: Any = Sent()
    topic = WaypointMarkers(node)
    topic.take(goal(*((float(x), 0.0) for x in range(MOST + 50))))
    assert len(node[-1].markers) == 2 * MOST
