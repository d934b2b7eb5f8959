"""The client of the tutorials, with callbacks; cancels at a feedback if it is told which."""

import argparse
import sys

import rclpy
from action_msgs.msg import GoalStatus
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient
from rclpy.node import Node


class FibonacciClient(Node):
    def __init__(self, order, cancel_at):
        super().__init__("fibonacci_client")
        self.order, self.cancel_at, self.seen = order, cancel_at, 0
        self.client = ActionClient(self, Fibonacci, "fibonacci")

    def send_goal(self):
        self.client.wait_for_server()
        print("send")
        future = self.client.send_goal_async(
            Fibonacci.Goal(order=self.order), feedback_callback=self.feedback
        )
        future.add_done_callback(self.answered)

    def answered(self, future):
        self.goal_handle = future.result()
        if not self.goal_handle.accepted:
            print("rejected")
            rclpy.shutdown()
            return
        print("accepted")
        self.goal_handle.get_result_async().add_done_callback(self.ended)

    def feedback(self, message):
        self.seen += 1
        print("feedback", self.seen, list(message.feedback.sequence)[-1])
        if self.seen == self.cancel_at:
            self.goal_handle.cancel_goal_async().add_done_callback(self.cancel_answered)

    def cancel_answered(self, future):
        print("canceling", len(future.result().goals_canceling))

    def ended(self, future):
        status, result = future.result().status, future.result().result
        print("succeeded" if status == GoalStatus.STATUS_SUCCEEDED else f"status {status}")
        print(list(result.sequence))
        rclpy.shutdown()


def main(args=None):
    parser = argparse.ArgumentParser()
    parser.add_argument("--order", type=int, default=6)
    parser.add_argument("--cancel-at", type=int)
    options = parser.parse_args(rclpy.utilities.remove_ros_args(sys.argv)[1:])
    rclpy.init(args=args)
    node = FibonacciClient(options.order, options.cancel_at)
    node.send_goal()
    rclpy.spin(node)


if __name__ == "__main__":
    main()
