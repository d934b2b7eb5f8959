"""Sends the pose of a moving frame."""

import math

import rclpy
from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from tf2_msgs.msg import TFMessage


class Broadcaster(Node):
    def __init__(self):
        super().__init__("broadcaster")
        self.publisher = self.create_publisher(TFMessage, "/tf", 100)
        self.angle = 0.0
        self.create_timer(0.1, self.send)

    def send(self):
        transform = TransformStamped()
        transform.header.stamp = self.get_clock().now().to_msg()
        transform.header.frame_id, transform.child_frame_id = "world", "moving"
        self.angle += 0.1
        transform.transform.rotation.z = math.sin(self.angle / 2)
        transform.transform.rotation.w = math.cos(self.angle / 2)
        self.publisher.publish(TFMessage(transforms=[transform]))


rclpy.init()
rclpy.spin(Broadcaster())
