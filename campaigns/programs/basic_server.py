"""A Fibonacci server: one number a half second. Words of its command line choose its shape."""

import sys
import time

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


class FibonacciServer(Node):
    def __init__(self):
        super().__init__("fibonacci_server")
        self.server = ActionServer(
            self,
            Fibonacci,
            "fibonacci",
            execute_callback=self.execute,
            callback_group=ReentrantCallbackGroup() if "reentrant" in sys.argv else None,
            goal_callback=self.goal,
            cancel_callback=self.cancel,
        )

    def goal(self, request):
        print("goal", request.order)
        return GoalResponse.REJECT if request.order > 40 else GoalResponse.ACCEPT

    def cancel(self, goal_handle):
        print("cancel")
        return CancelResponse.REJECT if "stubborn" in sys.argv else CancelResponse.ACCEPT

    def execute(self, goal_handle):
        print("execute")
        feedback = Fibonacci.Feedback(sequence=[0, 1])
        rate = self.create_rate(2) if "rate" in sys.argv else None
        for i in range(1, goal_handle.request.order):
            if goal_handle.is_cancel_requested:
                goal_handle.canceled()
                print("canceled")
                return Fibonacci.Result(sequence=feedback.sequence)
            if "raises" in sys.argv and i == 3:
                raise RuntimeError("the motor is gone")
            feedback.sequence.append(feedback.sequence[i] + feedback.sequence[i - 1])
            goal_handle.publish_feedback(feedback)
            if rate:
                rate.sleep()
            elif "clock" in sys.argv:
                self.get_clock().sleep_for(rclpy.duration.Duration(seconds=0.5))
            else:
                time.sleep(0.5)
        if "aborts" in sys.argv:
            goal_handle.abort()
        elif "forgets" not in sys.argv:
            goal_handle.succeed()
        print("done")
        return Fibonacci.Result(sequence=feedback.sequence)

    def destroy(self):
        self.server.destroy()
        super().destroy_node()


def main():
    rclpy.init()
    node = FibonacciServer()
    print("ready")
    try:
        if "threads" in sys.argv:
            executor = MultiThreadedExecutor(4)
            executor.add_node(node)
            executor.spin()
        else:
            rclpy.spin(node)
    except KeyboardInterrupt:
        print("interrupted")
    node.destroy()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
