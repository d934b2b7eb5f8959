"""Queues goals, and executes one after the other."""

import collections
import threading
import time

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


class QueueServer(Node):
    def __init__(self):
        super().__init__("queue_server")
        self.queue = collections.deque()
        self.lock = threading.Lock()
        self.current = None
        self.server = ActionServer(
            self,
            Fibonacci,
            "fibonacci",
            execute_callback=self.execute,
            handle_accepted_callback=self.accepted,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup(),
        )

    def accepted(self, goal_handle):
        with self.lock:
            if self.current is not None:
                print("queued", goal_handle.request.order)
                self.queue.append(goal_handle)
            else:
                self.current = goal_handle
                goal_handle.execute()

    def execute(self, goal_handle):
        order = goal_handle.request.order
        print("executes", order)
        try:
            numbers = [0, 1]
            for i in range(1, order):
                if goal_handle.is_cancel_requested:
                    goal_handle.canceled()
                    print("canceled", order)
                    return Fibonacci.Result(sequence=numbers)
                numbers.append(numbers[i] + numbers[i - 1])
                goal_handle.publish_feedback(Fibonacci.Feedback(sequence=numbers))
                time.sleep(0.5)
            goal_handle.succeed()
            print("done", order)
            return Fibonacci.Result(sequence=numbers)
        finally:
            with self.lock:
                try:
                    self.current = self.queue.popleft()
                    self.current.execute()
                except IndexError:
                    self.current = None


def main(args=None):
    rclpy.init(args=args)
    rclpy.spin(QueueServer(), executor=MultiThreadedExecutor())


if __name__ == "__main__":
    main()
