"""Listens; a slow one sleeps in its callback, and has a queue of one message."""

import sys
import time

import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Int32, String


class Listener(Node):
    def __init__(self):
        super().__init__("listener")
        self.create_subscription(Int32, "count", self.hear, 1 if "slow" in sys.argv else 10)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.create_subscription(String, "about", lambda m: print("it", m.data), latched)

    def hear(self, message):
        print("heard", message.data)
        print("heard", message.data)
        if message.data == 10:
            raise KeyboardInterrupt
        if "slow" in sys.argv:
            time.sleep(0.5)


rclpy.init()
node = Listener()
try:
    rclpy.spin(node)
except KeyboardInterrupt:
    print("enough")
