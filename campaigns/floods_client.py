"""Clients that flood: each sends as fast as it can, in a process of its own, and counts answers.

`python floods_client.py KIND NAME COUNT` prints what became of it as JSON.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from typing import Any

import rclpy
from action_msgs.srv import CancelGoal
from bt_mission_interfaces.action import ExecuteMission, Turn
from bt_mission_interfaces.srv import SetBreakpoint
from builtin_interfaces.msg import Duration as DurationMessage
from geometry_msgs.msg import TwistStamped
from nav2_msgs.action import Wait
from rclpy.action import ActionClient
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger

from bt_mission.core.wall_clock import Stopwatch, rest

PATIENCE_S = 30.0
"""Wall time without a response after which the client stops waiting, s."""

IN_A_ROW = 20
UNANSWERED = 2_000
"""The most open requests: the client's reader must not drop responses."""

DEEP = QoSProfile(depth=20_000)
BEHIND = Duration(seconds=10)
TYPES: dict[str, Any] = {"velocities": TwistStamped, "scans": LaserScan, "clock": Clock}
GOALS: dict[str, Any] = {
    "turns": (Turn, Turn.Goal(angle=3600.0, angular_velocity=0.1)),
    "waits": (Wait, Wait.Goal(time=DurationMessage(sec=3600))),
    "missions": (ExecuteMission, ExecuteMission.Goal(path="no_such_mission")),
}


class Answers:
    """Counts responses and refusals, and notes the time of the last one."""

    def __init__(self) -> None:
        self.sent = self.count = self.refused = 0
        self.last_s = 0.0
        self._watch = Stopwatch()

    def take(self, future: Any) -> None:
        """Count one."""
        answer = future.result()
        self.count += 1
        self.refused += not getattr(answer, "accepted", getattr(answer, "success", True))
        self.last_s = self._watch.elapsed_s

    @property
    def silence_s(self) -> float:
        """Seconds since the last one."""
        return self._watch.elapsed_s - self.last_s


def request(node: Node, kind: str, name: str) -> Callable[[int], Any]:
    """Return a function that sends one request of a kind, by its number, and returns a future."""
    if kind in GOALS:
        action, goal = GOALS[kind]
        sender = ActionClient(node, action, name, goal_service_qos_profile=DEEP)
        sender.wait_for_server()
        return lambda _: sender.send_goal_async(goal)
    service = {"cancels": CancelGoal, "breakpoints": SetBreakpoint}.get(kind, Trigger)
    client = node.create_client(service, name, qos_profile=DEEP)
    client.wait_for_service()
    if kind == "breakpoints":
        return lambda number: client.call_async(SetBreakpoint.Request(node=f"node {number}"))
    # A cancel of neither a goal nor a time is one of all goals.
    return lambda _: client.call_async(service.Request())


def ask(node: Node, kind: str, name: str, count: int) -> dict[str, float]:
    """Send a number of requests, and wait for the responses."""
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    send = request(node, kind, name)
    answers = Answers()
    while answers.count < count and answers.silence_s < PATIENCE_S:
        for _ in range(
            min(IN_A_ROW, count - answers.sent, UNANSWERED - answers.sent + answers.count)
        ):
            send(answers.sent).add_done_callback(answers.take)
            answers.sent += 1
        executor.spin_once(timeout_sec=0.0 if answers.sent < count else 0.1)
    return {
        "sent": answers.sent,
        "answered": answers.count,
        "refused": answers.refused,
        "seconds": answers.last_s,
    }


def publish(node: Node, kind: str, name: str, count: int) -> dict[str, float]:
    """Publish so many messages, each as soon as the one before it has gone."""
    publisher = node.create_publisher(TYPES[kind], name, 10)
    messages = [serialize_message(message) for message in _messages(node, kind)]
    while not publisher.get_subscription_count():
        rest(0.05)
    watch = Stopwatch()
    for index in range(count):
        publisher.publish(messages[index % len(messages)])
    return {"sent": count, "seconds": watch.elapsed_s}


def _messages(node: Node, kind: str) -> list[Any]:
    """Return messages that are sent in turns."""
    if kind == "clock":
        now = node.get_clock().now()
        return [Clock(clock=time.to_msg()) for time in (now, now - BEHIND)]
    message = TYPES[kind]()
    if kind == "velocities":
        message.twist.angular.z = 0.1
    return [message]


def main() -> None:
    """Flood once."""
    kind, name, count = sys.argv[1], sys.argv[2], int(sys.argv[3])
    rclpy.init()
    node = rclpy.create_node("flood", enable_rosout=False)
    flooded = (publish if kind in TYPES else ask)(node, kind, name, count)
    print(json.dumps(flooded), flush=True)
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
