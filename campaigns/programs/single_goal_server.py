"""Has one goal at a time: a new one aborts the other."""

import threading
import time

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


class SingleGoalServer(Node):
    def __init__(self):
        super().__init__("single_goal_server")
        self._goal_handle = None
        self._lock = threading.Lock()
        self._server = ActionServer(
            self,
            Fibonacci,
            "fibonacci",
            execute_callback=self.execute,
            goal_callback=lambda _: GoalResponse.ACCEPT,
            handle_accepted_callback=self.accepted,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup(),
        )

    def accepted(self, goal_handle):
        with self._lock:
            if self._goal_handle is not None and self._goal_handle.is_active:
                print("aborts", self._goal_handle.request.order)
                self._goal_handle.abort()
            self._goal_handle = goal_handle
        goal_handle.execute()

    def execute(self, goal_handle):
        numbers = [0, 1]
        for i in range(1, goal_handle.request.order):
            if not goal_handle.is_active:
                print("gives up", goal_handle.request.order)
                return Fibonacci.Result()
            if goal_handle.is_cancel_requested:
                goal_handle.canceled()
                return Fibonacci.Result()
            numbers.append(numbers[i] + numbers[i - 1])
            goal_handle.publish_feedback(Fibonacci.Feedback(sequence=numbers))
            time.sleep(0.5)
        with self._lock:
            if not goal_handle.is_active:
                return Fibonacci.Result()
            goal_handle.succeed()
        print("done", goal_handle.request.order)
        return Fibonacci.Result(sequence=numbers)


def main(args=None):
    rclpy.init(args=args)
    executor = MultiThreadedExecutor()
    rclpy.spin(SingleGoalServer(), executor=executor)


if __name__ == "__main__":
    main()
