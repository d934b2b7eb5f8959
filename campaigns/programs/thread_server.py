"""Executes in a thread of its own; the execute callback waits for it with a condition."""

import threading
import time

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


class ThreadServer(Node):
    def __init__(self):
        super().__init__("thread_server")
        self.condition = threading.Condition()
        self.stop = threading.Event()
        self.numbers = []
        self.server = ActionServer(
            self,
            Fibonacci,
            "fibonacci",
            self.execute,
            callback_group=ReentrantCallbackGroup(),
            cancel_callback=self.cancel,
        )

    def cancel(self, _):
        print("stops the thread")
        self.stop.set()
        return CancelResponse.ACCEPT

    def work(self, order):
        for _ in range(order):
            time.sleep(0.4)
            with self.condition:
                self.numbers.append(sum(self.numbers[-2:]) or 1)
                self.condition.notify_all()
            if self.stop.is_set():
                break

    def execute(self, goal):
        self.stop.clear()
        self.numbers = []
        worker = threading.Thread(target=self.work, args=(goal.request.order,))
        worker.start()
        seen = 0
        while worker.is_alive() or seen < len(self.numbers):
            with self.condition:
                self.condition.wait_for(lambda: len(self.numbers) > seen, timeout=0.1)
                if len(self.numbers) > seen:
                    seen = len(self.numbers)
                    goal.publish_feedback(Fibonacci.Feedback(sequence=self.numbers))
        worker.join()
        if self.stop.is_set():
            goal.canceled()
        else:
            goal.succeed()
        print("ended with", len(self.numbers))
        return Fibonacci.Result(sequence=self.numbers)


def main():
    rclpy.init()
    node = ThreadServer()
    executor = MultiThreadedExecutor(num_threads=3)
    executor.add_node(node)
    try:
        executor.spin()
    except KeyboardInterrupt:
        pass
    finally:
        executor.shutdown()
        node.destroy_node()


if __name__ == "__main__":
    main()
