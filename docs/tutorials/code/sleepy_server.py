"""A Fibonacci server that sleeps in its execute callback."""

import sys
import time

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionServer, CancelResponse
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node


class FibonacciServer(Node):
    def __init__(self):
        super().__init__("fibonacci")
        self.server = ActionServer(
            self,
            Fibonacci,
            "fibonacci",
            self.execute,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    def execute(self, goal):
        numbers = [0, 1]
        for _ in range(goal.request.order):
            if goal.is_cancel_requested:
                goal.canceled()
                return Fibonacci.Result(sequence=numbers)
            numbers.append(numbers[-1] + numbers[-2])
            goal.publish_feedback(Fibonacci.Feedback(sequence=numbers))
            time.sleep(1)
        goal.succeed()
        return Fibonacci.Result(sequence=numbers)


def main():
    rclpy.init()
    node = FibonacciServer()
    try:
        if "--threads" in sys.argv:
            executor = MultiThreadedExecutor()
            executor.add_node(node)
            executor.spin()
        else:
            rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass


if __name__ == "__main__":
    main()
