"""Looks up a frame twice a second in what has been heard, as a buffer would, and its age."""

import math

import rclpy
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.time import Time
from tf2_msgs.msg import TFMessage


class FrameListener(Node):
    def __init__(self):
        super().__init__("frame_listener")
        self.frames = {}
        self.looks = 0
        self.create_subscription(TFMessage, "/tf", self.hear, 100)

    def hear(self, message):
        if not self.frames:
            print("first")
            self.create_timer(0.5, self.look)
        for transform in message.transforms:
            self.frames[transform.child_frame_id] = transform

    def look(self):
        self.looks += 1
        frame = self.frames.get("moving")
        age = self.get_clock().now() - Time.from_msg(frame.header.stamp)
        is_fresh = age < Duration(seconds=0.15)
        turned = 2 * math.atan2(frame.transform.rotation.z, frame.transform.rotation.w)
        print("look", self.looks, "fresh" if is_fresh else "old", turned > 0.1)
        if self.looks == 4:
            rclpy.shutdown()


rclpy.init()
rclpy.spin(FrameListener())
