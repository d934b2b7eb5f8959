"""Asks for a result after the server has dropped it."""

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer
from rclpy.node import Node


class Short(Node):
    def __init__(self):
        super().__init__("short")
        self.server = ActionServer(self, Fibonacci, "short", self.execute, result_timeout=1)
        self.client = ActionClient(self, Fibonacci, "short")

    def execute(self, goal):
        goal.succeed()
        return Fibonacci.Result(sequence=[1])


rclpy.init()
node = Short()
node.client.wait_for_server()
print("send")
future = node.client.send_goal_async(Fibonacci.Goal(order=1))
rclpy.spin_until_future_complete(node, future)
for seconds in (0.3, 1.5):
    rclpy.spin_until_future_complete(node, rclpy.Future(), timeout_sec=seconds)
    result = future.result().get_result_async()
    rclpy.spin_until_future_complete(node, result)
    print("status", result.result().status, list(result.result().result.sequence))
