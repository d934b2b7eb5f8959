"""Cancels its goal at Ctrl-C, and leaves when the server has confirmed."""

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions


class InterruptedClient(Node):
    def __init__(self):
        super().__init__("interrupted_client")
        self.goal_succeeded = False
        self.goal_cancelled = False
        self.stop = False
        self.client = ActionClient(self, Fibonacci, "fibonacci")

    def send_goal(self, order):
        self.client.wait_for_server()
        print("send")
        self.future = self.client.send_goal_async(
            Fibonacci.Goal(order=order), feedback_callback=self.feedback
        )
        self.future.add_done_callback(self.response)

    def response(self, future):
        self.goal_handle = future.result()
        self.goal_handle.get_result_async().add_done_callback(self.result)

    def feedback(self, message):
        print("feedback", len(message.feedback.sequence))

    def result(self, future):
        print("status", future.result().status)
        self.goal_succeeded = True

    def cancel(self):
        print("cancels")
        self.goal_handle.cancel_goal_async().add_done_callback(self.cancelled)

    def cancelled(self, future):
        print("answer", len(future.result().goals_canceling))
        self.goal_cancelled = True


def main(args=None):
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    node = InterruptedClient()
    node.send_goal(20)
    while not node.goal_succeeded:
        try:
            rclpy.spin_once(node, timeout_sec=0.1)
            if node.stop and node.goal_cancelled:
                break
        except KeyboardInterrupt:
            print("ctrl-c")
            node.stop = True
            node.cancel()
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
