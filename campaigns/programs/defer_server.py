"""Accepts a goal at once, and executes it when a timer says so."""

import time

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


class DeferringServer(Node):
    def __init__(self):
        super().__init__("deferring_server")
        self._goal = None
        self._timer = None
        self._server = ActionServer(
            self,
            Fibonacci,
            "fibonacci",
            execute_callback=self.execute,
            handle_accepted_callback=self.accepted,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup(),
        )

    def accepted(self, goal_handle):
        print("deferred")
        self._goal = goal_handle
        self._timer = self.create_timer(1.5, self.begin)

    def begin(self):
        print("begins")
        self._goal.execute()
        self._timer.cancel()

    def execute(self, goal_handle):
        numbers = [0, 1]
        for i in range(1, goal_handle.request.order):
            if goal_handle.is_cancel_requested:
                goal_handle.canceled()
                print("canceled")
                return Fibonacci.Result()
            numbers.append(numbers[i] + numbers[i - 1])
            goal_handle.publish_feedback(Fibonacci.Feedback(sequence=numbers))
            time.sleep(0.5)
        goal_handle.succeed()
        return Fibonacci.Result(sequence=numbers)


def main(args=None):
    rclpy.init(args=args)
    server = DeferringServer()
    rclpy.spin(server, executor=MultiThreadedExecutor())


if __name__ == "__main__":
    main()
