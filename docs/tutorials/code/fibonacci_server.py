"""Your own action server: Fibonacci numbers, one every half second."""

import contextlib

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.task import Future


class FibonacciServer(Node):
    def __init__(self, **options):
        super().__init__("fibonacci_server", **options)
        callbacks = {"goal_callback": self.consider, "cancel_callback": self.give_way}
        self.server = ActionServer(self, Fibonacci, "fibonacci", self.count, **callbacks)

    def consider(self, goal):
        return GoalResponse.ACCEPT if 1 <= goal.order <= 40 else GoalResponse.REJECT

    def give_way(self, _goal):
        return CancelResponse.ACCEPT

    async def count(self, goal):
        numbers = [0, 1][: goal.request.order]
        while len(numbers) < goal.request.order and not goal.is_cancel_requested:
            await self.pause(0.5)
            numbers.append(numbers[-1] + numbers[-2])
            goal.publish_feedback(Fibonacci.Feedback(sequence=numbers))
        if goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.succeed()
        return Fibonacci.Result(sequence=numbers)

    async def pause(self, seconds):
        over = Future()
        timer = self.create_timer(seconds, lambda: over.set_result(None))
        await over
        self.destroy_timer(timer)


if __name__ == "__main__":
    rclpy.init()
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(FibonacciServer())
