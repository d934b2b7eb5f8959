"""A timer that is a state machine, with changing periods, one-shots, and a late callback."""

import time

import rclpy
from rclpy.node import Node


class Machine(Node):
    def __init__(self):
        super().__init__("machine")
        self.state, self.ticks = "idle", 0
        self.timer = self.create_timer(0.25, self.tick)
        self.once = self.create_timer(0.6, self.alarm)
        print("start")

    def alarm(self):
        self.once.cancel()
        print("alarm")

    def tick(self):
        self.ticks += 1
        print(self.state, self.ticks)
        if self.state == "idle" and self.ticks == 4:
            self.state = "slow"
            self.destroy_timer(self.timer)
            self.timer = self.create_timer(0.5, self.tick)
        elif self.state == "slow" and self.ticks == 5:
            time.sleep(1.2)
            print("late")
            self.state = "after"
        elif self.ticks == 8:
            self.timer.reset()
            self.once.reset()
        elif self.ticks == 10:
            rclpy.shutdown()


rclpy.init()
rclpy.spin(Machine())
print("end")
