"""Two nodes in one executor: the sleep of one delays the other, or does not."""

import sys
import time

import rclpy
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node


class Beat(Node):
    def __init__(self):
        super().__init__("beat")
        self.count = 0
        self.create_timer(0.3, self.beat)

    def beat(self):
        self.count += 1
        print("beat", self.count)
        if self.count == 8:
            rclpy.shutdown()


class Sleeper(Node):
    def __init__(self):
        super().__init__("sleeper")
        self.create_timer(1.0, self.sleep)

    def sleep(self):
        print("sleeps")
        time.sleep(0.7)
        print("awake")


rclpy.init()
executor = MultiThreadedExecutor(2) if "threads" in sys.argv else SingleThreadedExecutor()
for node in (Beat(), Sleeper()):
    executor.add_node(node)
print("start")
executor.spin()
