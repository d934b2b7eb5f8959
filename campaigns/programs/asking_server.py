"""An action server that asks a service for each number, in the way that an argument names."""

import sys

import rclpy
from example_interfaces.action import Fibonacci
from example_interfaces.srv import AddTwoInts
from rclpy.action import ActionServer
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node


class AskingServer(Node):
    def __init__(self, how):
        super().__init__("asking_server")
        group = ReentrantCallbackGroup()
        execute = {"call": self.call, "await": self.wait, "spin": self.spin}[how]
        self.client = self.create_client(AddTwoInts, "add", callback_group=group)
        self.helper = rclpy.create_node("helper")
        self.other = self.helper.create_client(AddTwoInts, "add")
        self.client.wait_for_service()
        self.other.wait_for_service()
        self.server = ActionServer(self, Fibonacci, "fibonacci", execute, callback_group=group)

    def call(self, goal):
        numbers = [0, 1]
        for _ in range(goal.request.order):
            answer = self.client.call(AddTwoInts.Request(a=numbers[-1], b=numbers[-2]))
            numbers.append(answer.sum)
            goal.publish_feedback(Fibonacci.Feedback(sequence=numbers))
        goal.succeed()
        return Fibonacci.Result(sequence=numbers)

    async def wait(self, goal):
        numbers = [0, 1]
        for _ in range(goal.request.order):
            answer = await self.client.call_async(AddTwoInts.Request(a=numbers[-1], b=numbers[-2]))
            numbers.append(answer.sum)
            goal.publish_feedback(Fibonacci.Feedback(sequence=numbers))
        goal.succeed()
        return Fibonacci.Result(sequence=numbers)

    def spin(self, goal):
        executor = SingleThreadedExecutor()
        numbers = [0, 1]
        for _ in range(goal.request.order):
            future = self.other.call_async(AddTwoInts.Request(a=numbers[-1], b=numbers[-2]))
            rclpy.spin_until_future_complete(self.helper, future, executor=executor)
            numbers.append(future.result().sum)
            goal.publish_feedback(Fibonacci.Feedback(sequence=numbers))
        goal.succeed()
        return Fibonacci.Result(sequence=numbers)


def main():
    rclpy.init()
    node = AskingServer(sys.argv[1])
    if "threads" in sys.argv:
        executor = MultiThreadedExecutor()
        executor.add_node(node)
        executor.spin()
    else:
        rclpy.spin(node)


if __name__ == "__main__":
    main()
