"""Sends a second goal half way through the first; both answers are printed as they come."""

import sys

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient
from rclpy.node import Node


class TwoGoals(Node):
    def __init__(self):
        super().__init__("two_goals")
        self.client = ActionClient(self, Fibonacci, "fibonacci")
        self.client.wait_for_server()
        print("go")
        self.open = 2
        self.send(6)
        self.timer = self.create_timer(0.9, self.second)

    def second(self):
        self.timer.cancel()
        print("second")
        self.send(4)

    def send(self, order):
        future = self.client.send_goal_async(Fibonacci.Goal(order=order))
        future.add_done_callback(lambda future: self.answered(order, future))

    def answered(self, order, future):
        print(order, "accepted" if future.result().accepted else "rejected")
        if "cancel" in sys.argv and order == 4:
            future.result().cancel_goal_async()
        result = future.result().get_result_async()
        result.add_done_callback(lambda future: self.ended(order, future))

    def ended(self, order, future):
        print(order, "status", future.result().status, len(future.result().result.sequence))
        self.open -= 1
        if not self.open:
            raise SystemExit(0)


rclpy.init()
node = TwoGoals()
try:
    rclpy.spin(node)
finally:
    node.destroy_node()
    rclpy.shutdown()
