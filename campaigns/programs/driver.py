"""Drives half a metre by odometry, on a timer, and stops."""

import math

import rclpy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node


class Driver(Node):
    def __init__(self):
        super().__init__("driver")
        self.start = self.far = None
        self.create_subscription(Odometry, "odom", self.odom, 10)
        self.publisher = self.create_publisher(TwistStamped, "cmd_vel", 10)
        self.timer = self.create_timer(0.1, self.drive)

    def odom(self, message):
        place = message.pose.pose.position.x, message.pose.pose.position.y
        if self.start is None:
            print("odometry")
            self.start = place
        self.far = math.dist(self.start, place)

    def drive(self):
        message = TwistStamped()
        message.header.stamp = self.get_clock().now().to_msg()
        if self.far is not None and self.far < 0.5:
            message.twist.linear.x = 0.25
        self.publisher.publish(message)
        if self.far is not None and self.far >= 0.5:
            print("there")
            rclpy.shutdown()


rclpy.init()
rclpy.spin(Driver())
