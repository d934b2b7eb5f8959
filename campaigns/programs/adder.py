"""A service that needs its time."""

import sys
import time

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


class Adder(Node):
    def __init__(self):
        super().__init__("adder")
        group = ReentrantCallbackGroup() if "reentrant" in sys.argv else None
        self.create_service(AddTwoInts, "add", self.add, callback_group=group)

    def add(self, request, response):
        print(f"asked {request.a} {request.b}")
        time.sleep(0.4)
        response.sum = request.a + request.b
        return response


def main():
    rclpy.init()
    node = Adder()
    if "threads" in sys.argv:
        executor = MultiThreadedExecutor()
        executor.add_node(node)
        executor.spin()
    else:
        rclpy.spin(node)


if __name__ == "__main__":
    main()
