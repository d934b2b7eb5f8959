"""Spins its own node within a callback, as is often tried."""

import sys

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


class Nested(Node):
    def __init__(self):
        super().__init__("nested")
        self.client = self.create_client(AddTwoInts, "add")
        self.client.wait_for_service()
        self.calls = 0
        self.create_timer(0.5, self.tick)

    def tick(self):
        self.calls += 1
        print("tick", self.calls)
        future = self.client.call_async(AddTwoInts.Request(a=self.calls, b=1))
        try:
            rclpy.spin_until_future_complete(self, future, timeout_sec=1.0)
            print("sum", future.result().sum if future.done() else None)
        except Exception as error:
            print(type(error).__name__)
        if self.calls == 3:
            sys.exit(0)


rclpy.init()
node = Nested()
print("start")
if "threads" in sys.argv:
    executor = MultiThreadedExecutor()
    executor.add_node(node)
    executor.spin()
else:
    rclpy.spin(node)
