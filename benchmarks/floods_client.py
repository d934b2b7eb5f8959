"""Clients that flood: each sends as fast as it can, in a process of its own, and counts answers.

`python floods_client.py KIND NAME COUNT` prints what became of it as JSON.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from typing import Any

import rclpy
from action_msgs.srv import CancelGoal
from bt_mission_interfaces.action import ExecuteMission, Turn
from bt_mission_interfaces.srv import SetBreakpoint
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger

PATIENCE_S = 200.0
"""Wall time after the last request, s, after which answers are no longer waited for."""

UNANSWERED = 2_000
"""Requests on their way at most: the client's own reader must not drop answers."""

DEEP = QoSProfile(depth=20_000)
BEHIND_NS = 10_000_000_000
MESSAGES = {"velocities": TwistStamped, "odometry": Odometry, "scans": LaserScan}


class Answers:
    """Counts answers, and those that say no, and when the last one came."""

    def __init__(self) -> None:
        self.sent = self.count = self.refused = 0
        self.started_s = self.last_s = time.monotonic()

    def take(self, future: Any) -> None:
        """Count one."""
        answer = future.result()
        self.count += 1
        self.refused += not getattr(answer, "accepted", getattr(answer, "success", True))
        self.last_s = time.monotonic()


def request(node: Node, kind: str, name: str) -> Callable[[int], Any]:
    """Return what sends one request of a kind, by its number, and gives a future."""
    if kind in ("goals", "missions"):
        action, goal = (
            (Turn, Turn.Goal(angle=3600.0, angular_velocity=0.1))
            if kind == "goals"
            else (ExecuteMission, ExecuteMission.Goal(file="nothing.yaml"))
        )
        sender = ActionClient(node, action, name, goal_service_qos_profile=DEEP)
        sender.wait_for_server()
        return lambda _: sender.send_goal_async(goal)
    types = {"cancels": CancelGoal, "breakpoints": SetBreakpoint}
    service = types.get(kind, Trigger)
    client = node.create_client(service, name, qos_profile=DEEP)
    client.wait_for_service()
    if kind == "breakpoints":
        return lambda i: client.call_async(SetBreakpoint.Request(node=f"node {i}"))
    # A cancel of neither a goal nor a time is one of all goals.
    return lambda _: client.call_async(service.Request())


def ask(node: Node, kind: str, name: str, count: int) -> dict[str, float]:
    """Send so many requests, and wait for the answers."""
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    send, answers = request(node, kind, name), Answers()
    answers.started_s = time.monotonic()
    waiting = answers.started_s
    while answers.count < count and time.monotonic() - waiting < PATIENCE_S:
        while answers.sent < count and answers.sent - answers.count < UNANSWERED:
            send(answers.sent).add_done_callback(answers.take)
            answers.sent += 1
            waiting = time.monotonic()
            if answers.sent % 20 == 0:
                break
        executor.spin_once(timeout_sec=0.0 if answers.sent < count else 0.1)
    return {
        "sent": answers.sent,
        "answered": answers.count,
        "refused": answers.refused,
        "seconds": answers.last_s - answers.started_s,
    }


def publish(node: Node, kind: str, name: str, count: int) -> dict[str, float]:
    """Publish so many messages, each as soon as the one before it has gone."""
    if kind == "clock":
        publisher = node.create_publisher(Clock, name, 10)
    else:
        publisher = node.create_publisher(MESSAGES[kind], name, 10)
        message = MESSAGES[kind]()
        if kind == "velocities":
            message.twist.angular.z = 0.1
        data = serialize_message(message)
    while not publisher.get_subscription_count():
        time.sleep(0.05)
    started_s = time.monotonic()
    for index in range(count):
        if kind == "clock":
            # Now and ten seconds ago in turns.
            now_ns = time.time_ns() - BEHIND_NS * (index % 2)
            data = Clock()
            data.clock.sec, data.clock.nanosec = divmod(now_ns, 1_000_000_000)
        publisher.publish(data)
    return {"sent": count, "seconds": time.monotonic() - started_s}


def main() -> None:
    """Flood once."""
    kind, name, count = sys.argv[1], sys.argv[2], int(sys.argv[3])
    rclpy.init()
    node = rclpy.create_node("flood", enable_rosout=False)
    is_topic = kind == "clock" or kind in MESSAGES
    found = (publish if is_topic else ask)(node, kind, name, count)
    print(json.dumps(found), flush=True)
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
