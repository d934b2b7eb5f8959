"""Timers of one group, mutually exclusive or reentrant, in several threads."""

import sys
import threading
import time

import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


class Groups(Node):
    def __init__(self):
        super().__init__("groups")
        kind = ReentrantCallbackGroup if "reentrant" in sys.argv else MutuallyExclusiveCallbackGroup
        group = kind()
        self.lock = threading.Lock()
        self.running = self.most = self.calls = 0
        for name in "ab":
            self.create_timer(0.5, lambda name=name: self.work(name), callback_group=group)
        self.create_timer(2.9, self.stop, callback_group=MutuallyExclusiveCallbackGroup())

    def work(self, name):
        with self.lock:
            self.running += 1
            self.calls += 1
            self.most = max(self.most, self.running)
        time.sleep(0.2)
        with self.lock:
            self.running -= 1

    def stop(self):
        print("most", self.most, "calls", self.calls)
        rclpy.shutdown()


rclpy.init()
executor = MultiThreadedExecutor(4)
executor.add_node(Groups())
print("start")
executor.spin()
