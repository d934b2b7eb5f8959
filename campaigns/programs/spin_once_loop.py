"""A loop of spin_once with other work in between; Ctrl-C ends it."""

import time

import rclpy
from rclpy.node import Node

rclpy.init()
node = Node("loop")
ticks = []
node.create_timer(0.2, lambda: ticks.append(0))
loops = 0
print("start")
try:
    while rclpy.ok():
        rclpy.spin_once(node, timeout_sec=0.5)
        time.sleep(0.3)
        loops += 1
        print("loop", loops, "ticks", len(ticks))
except KeyboardInterrupt:
    print("interrupted")
finally:
    print("ok", rclpy.ok())
    rclpy.try_shutdown()
