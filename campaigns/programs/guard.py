"""A guard condition that a thread triggers, and a timer of a steady clock."""

import threading

import rclpy
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node


class Guarded(Node):
    def __init__(self):
        super().__init__("guarded")
        self.guard = self.create_guard_condition(self.woken)
        self.count = 0
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(0.5, lambda: print("steady"), clock=steady)
        threading.Timer(0.75, self.guard.trigger).start()

    def woken(self):
        self.count += 1
        print("woken", self.count)
        if self.count == 2:
            rclpy.shutdown()
        threading.Timer(1.0, self.guard.trigger).start()


rclpy.init()
node = Guarded()
print("start")
rclpy.spin(node)
