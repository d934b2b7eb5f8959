"""A server without a class: functions, and a logger in a global."""

import time

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor

logger = None


def cancel(goal):
    logger.info("a request to cancel")
    print("cancel")
    return CancelResponse.ACCEPT


async def execute(goal):
    print("executes")
    feedback = Fibonacci.Feedback(sequence=[0, 1])
    for i in range(1, goal.request.order):
        if goal.is_cancel_requested:
            goal.canceled()
            print("is canceled")
            return Fibonacci.Result()
        feedback.sequence.append(feedback.sequence[i] + feedback.sequence[i - 1])
        goal.publish_feedback(feedback)
        time.sleep(0.5)
    goal.succeed()
    return Fibonacci.Result(sequence=feedback.sequence)


def main(args=None):
    global logger
    rclpy.init(args=args)
    node = rclpy.create_node("function_server")
    logger = node.get_logger()
    server = ActionServer(
        node,
        Fibonacci,
        "fibonacci",
        execute_callback=execute,
        cancel_callback=cancel,
        callback_group=ReentrantCallbackGroup(),
    )
    rclpy.spin(node, executor=MultiThreadedExecutor())
    server.destroy()


if __name__ == "__main__":
    main()
