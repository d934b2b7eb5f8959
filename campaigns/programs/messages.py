"""Waits for single messages, with and without a limit."""

import rclpy
from rclpy.node import Node
from rclpy.wait_for_message import wait_for_message
from std_msgs.msg import Int32


def main():
    rclpy.init()
    node = Node("waits")
    print("start")
    print(wait_for_message(Int32, node, "silent", time_to_wait=0.7))
    for _ in range(3):
        _, message = wait_for_message(Int32, node, "count", time_to_wait=5.0)
        print("got", type(message).__name__)
    rclpy.shutdown()


main()
