"""Its own handler of SIGINT sets a flag; the robot is stopped before the end."""

import signal
import sys
import time

import rclpy
from rclpy.node import Node
from std_msgs.msg import String


class Stopper(Node):
    def __init__(self):
        super().__init__("stopper")
        self.stopping = False
        self.publisher = self.create_publisher(String, "command", 1)
        signal.signal(signal.SIGINT, self.on_signal)
        self.count = 0
        self.create_timer(0.4, self.tick)

    def on_signal(self, number, frame):
        print("signal", number)
        self.stopping = True

    def tick(self):
        self.count += 1
        print("tick", self.count)
        if self.stopping:
            self.publisher.publish(String(data="stop"))
            time.sleep(0.3)
            print("stopped")
            sys.exit(0)


rclpy.init()
node = Stopper()
print("start")
rclpy.spin(node)
