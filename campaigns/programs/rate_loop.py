"""The loop of ROS 1 in ROS 2: a rate in the main thread, and a thread that spins."""

import threading

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import Int32


def spin(node):
    try:
        rclpy.spin(node)
    except ExternalShutdownException:
        pass


def main():
    rclpy.init()
    node = Node("rate_loop")
    got = []
    publisher = node.create_publisher(Int32, "loop", 10)
    node.create_subscription(Int32, "loop", lambda m: got.append(m.data), 10)
    thread = threading.Thread(target=spin, args=(node,), daemon=True)
    thread.start()
    rate = node.create_rate(4)
    count = 0
    print("start")
    try:
        while rclpy.ok():
            rate.sleep()
            count += 1
            publisher.publish(Int32(data=count))
            print("loop", count, len(got))
    except KeyboardInterrupt:
        print("stop")
    rclpy.try_shutdown()
    thread.join()


if __name__ == "__main__":
    main()
