"""What the servers hear and tell beside their actions: stop, motors, executives, plan, state."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from geometry_msgs.msg import PoseStamped
from lifecycle_msgs.msg import State
from lifecycle_msgs.srv import GetState
from nav_msgs.msg import Path
from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import LivelinessPolicy, QoSProfile
from std_msgs.msg import Bool, Empty
from std_srvs.srv import Trigger

from action_servers.core.interlock import Interlock
from action_servers.robot_io.messages import MAP_FRAME
from action_servers.robot_io.sensors import LATCHED
from bt_mission.core.dds.liveliness import LEASE_S, TOPIC

if TYPE_CHECKING:
    from rclpy.node import Node

    from action_servers.core.grid import Floats

PRESENCE = QoSProfile(
    depth=1,
    liveliness=LivelinessPolicy.AUTOMATIC,
    liveliness_lease_duration=Duration(nanoseconds=round(LEASE_S * 1e9)),
)


class Switches:
    """The services `stop` and `release`, and the topic `motors_on`, of an interlock.

    A robot that does not tell about its motors has them on.
    """

    def __init__(self, node: Node, interlock: Interlock) -> None:
        self._log: Any = node.get_logger()
        self._interlock = interlock
        node.create_service(Trigger, "stop", self._stop)
        node.create_service(Trigger, "release", self._release)
        node.create_subscription(Bool, "motors_on", self._hear_of_motors, LATCHED)

    def _stop(self, _request: Any, response: Any) -> Any:
        return self._answered(response, self._interlock.stop())

    def _release(self, _request: Any, response: Any) -> Any:
        return self._answered(response, self._interlock.release())

    def _answered(self, response: Any, done: str) -> Any:
        self._log.info(done)
        response.success, response.message = True, done
        return response

    def _hear_of_motors(self, message: Any) -> None:
        self._interlock.set_motors(on=message.data)


def watch_executives(node: Node, on_lost: Callable[[str], None]) -> None:
    """Tell `on_lost` why, when an executive dies, and when the last one leaves.

    A client that is no executive of ours is not watched.
    """

    def changed(status: Any) -> None:
        if status.not_alive_count_change > 0:
            on_lost(f"the executive has died: its liveliness lease of {LEASE_S:g} s expired")
        elif status.alive_count_change < 0 and status.alive_count == 0:
            on_lost("the executive has left")

    events = SubscriptionEventCallbacks(liveliness=changed, use_default_callbacks=False)
    node.create_subscription(Empty, TOPIC, lambda _: None, PRESENCE, event_callbacks=events)


class PlanTopic:
    """Publishes the path that is driven on `plan`, as Nav2 does, latched: for RViz and Foxglove.

    `lean`: only while somebody subscribes to it.
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
        path.header.frame_id = MAP_FRAME
        path.header.stamp = self._clock.now().to_msg()
        for x, y in points.tolist():
            pose = PoseStamped(header=path.header)
            pose.pose.position.x, pose.pose.position.y = x, y
            path.poses.append(pose)
        self._publisher.publish(path)


def answer_as_navigator(node: Node, is_ready: Callable[[], bool]) -> None:
    """Offer `bt_navigator/get_state`, which programs for Nav2 ask until they hear "active".

    Args:
        node: Of the servers.
        is_ready: Whether navigation has all that it needs; "inactive" until then.
    """

    def answer(_request: Any, response: Any) -> Any:
        state = response.current_state
        state.id, state.label = (
            (State.PRIMARY_STATE_ACTIVE, "active")
            if is_ready()
            else (State.PRIMARY_STATE_INACTIVE, "inactive")
        )
        return response

    node.create_service(GetState, "bt_navigator/get_state", answer)
