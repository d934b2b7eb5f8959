"""Publishes a count ten times, on a timer."""

import sys

import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Int32, String


class Talker(Node):
    def __init__(self):
        super().__init__("talker")
        self.publisher = self.create_publisher(Int32, "count", 10)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.about = self.create_publisher(String, "about", latched)
        self.about.publish(String(data="counts to ten"))
        self.count = 0
        self.wait = self.create_timer(0.05, self.look)

    def look(self):
        if self.publisher.get_subscription_count():
            self.wait.cancel()
            print("first")
            self.create_timer(float(sys.argv[1]), self.tick)

    def tick(self):
        self.count += 1
        self.publisher.publish(Int32(data=self.count))
        if self.count == 10:
            raise SystemExit


rclpy.init()
rclpy.spin(Talker())
