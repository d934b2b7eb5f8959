"""The services `stop` and `release`, and the topic `motors_on`."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from action_servers.core.interlock import Interlock

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Switches:
    """Joins an interlock to ROS. A robot that does not tell about its motors has them on."""

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
