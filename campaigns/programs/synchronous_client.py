"""Spins in a thread, and calls the blocking functions of the client in its main thread."""

import threading

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient
from rclpy.node import Node


def main():
    rclpy.init()
    node = Node("synchronous_client")
    client = ActionClient(node, Fibonacci, "fibonacci")
    spinner = threading.Thread(target=rclpy.spin, args=(node,), daemon=True)
    spinner.start()
    client.wait_for_server()
    for order in (3, 5):
        print("send", order)
        answer = client.send_goal(
            Fibonacci.Goal(order=order),
            feedback_callback=lambda m: print("feedback", len(m.feedback.sequence)),
        )
        print("status", answer.status, list(answer.result.sequence))
    rclpy.shutdown()
    spinner.join()
    print("end")


if __name__ == "__main__":
    main()
