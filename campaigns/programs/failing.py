"""Ends in the way that an argument names: its exit code counts."""

import atexit
import os
import sys
import threading
import time

import rclpy
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


class Failing(Node):
    def __init__(self, how):
        super().__init__("failing")
        self.how, self.ticks = how, 0
        self.create_timer(0.5, self.tick)

    def tick(self):
        self.ticks += 1
        if self.ticks == 1:
            print(self.how)
        if self.ticks == 4:
            rclpy.shutdown()
        if self.how == "raises":
            raise ValueError("in a timer")
        if self.how == "exits":
            sys.exit(3)
        if self.how == "says":
            sys.exit("no map")
        if self.how == "shutdown":
            rclpy.shutdown()
        if self.how == "destroys":
            self.destroy_node()
            threading.Timer(0.5, rclpy.shutdown).start()
        if self.how == "thread":
            threading.Thread(target=self.fail).start()
            time.sleep(0.3)
            print("goes on")
            rclpy.shutdown()
        if self.how == "leaves":
            os._exit(9)

    def fail(self):
        raise ValueError("in a thread")


def main():
    rclpy.init()
    atexit.register(print, "at exit")
    rclpy.get_default_context().on_shutdown(lambda: print("on shutdown"))
    node = Failing(sys.argv[1])
    print("start")
    executor = MultiThreadedExecutor() if "threads" in sys.argv else None
    try:
        rclpy.spin(node, executor)
    except rclpy.executors.ExternalShutdownException:
        print("external")
    finally:
        print("finally", rclpy.ok())


if __name__ == "__main__":
    main()
