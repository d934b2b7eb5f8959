"""Waits for an event that a callback sets; the executor spins in a thread."""

import threading

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


class EventClient(Node):
    def __init__(self):
        super().__init__("event_client")
        self.done = threading.Event()
        self.status = None
        self.client = ActionClient(
            self, Fibonacci, "fibonacci", callback_group=ReentrantCallbackGroup()
        )
        group = MutuallyExclusiveCallbackGroup()
        self.timer = self.create_timer(0.25, self.run, callback_group=group)

    def run(self):
        self.timer.cancel()
        self.client.wait_for_server()
        print("send")
        future = self.client.send_goal_async(Fibonacci.Goal(order=4))
        future.add_done_callback(self.accepted)
        in_time = self.done.wait(timeout=5.0)
        print("in time" if in_time else "too late", self.status)
        rclpy.shutdown()

    def accepted(self, future):
        future.result().get_result_async().add_done_callback(self.ended)

    def ended(self, future):
        self.status = future.result().status
        self.done.set()


def main():
    rclpy.init()
    executor = MultiThreadedExecutor()
    executor.add_node(EventClient())
    try:
        executor.spin()
    except rclpy.executors.ExternalShutdownException:
        print("shut down")


if __name__ == "__main__":
    main()
