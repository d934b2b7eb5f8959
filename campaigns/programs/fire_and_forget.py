"""Sends a goal, sees that it is accepted, and leaves."""

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient


def main():
    rclpy.init()
    node = rclpy.create_node("fire_and_forget")
    client = ActionClient(node, Fibonacci, "fibonacci")
    client.wait_for_server()
    print("send")
    future = client.send_goal_async(Fibonacci.Goal(order=4))
    rclpy.spin_until_future_complete(node, future)
    print("accepted", future.result().accepted)
    client.destroy()
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
