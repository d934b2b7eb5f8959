"""Sends one goal after the other from the callback of a result, and counts what came of them."""

from collections import Counter

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient
from rclpy.action.client import GoalStatus
from rclpy.node import Node


class Patrol(Node):
    def __init__(self):
        super().__init__("patrol")
        self.declare_parameter("rounds", 3)
        self.left = self.get_parameter("rounds").value
        self.ends = Counter()
        self.client = ActionClient(self, Fibonacci, "fibonacci")
        self.watchdog = self.create_timer(1.25, self.too_long)
        self.goal_handle = None
        self.client.wait_for_server()
        print("go")
        self.next()

    def next(self):
        if not self.left:
            print(sorted(self.ends.items()))
            raise SystemExit
        self.left -= 1
        self.watchdog.reset()
        future = self.client.send_goal_async(Fibonacci.Goal(order=2 + 2 * (self.left % 2)))
        future.add_done_callback(self.accepted)

    def accepted(self, future):
        self.goal_handle = future.result()
        print("goal", self.left)
        self.goal_handle.get_result_async().add_done_callback(self.ended)

    def too_long(self):
        self.watchdog.cancel()
        print("too long")
        self.goal_handle.cancel_goal_async()

    def ended(self, future):
        name = {
            GoalStatus.STATUS_SUCCEEDED: "succeeded",
            GoalStatus.STATUS_CANCELED: "canceled",
        }.get(future.result().status, "other")
        print(name)
        self.ends[name] += 1
        self.next()


rclpy.init()
node = Patrol()
try:
    rclpy.spin(node)
except SystemExit:
    rclpy.shutdown()
