"""A client that cancels its goal at the fifth feedback."""

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient
from rclpy.node import Node


class Client(Node):
    def __init__(self):
        super().__init__("client")
        self.count = 0
        self.client = ActionClient(self, Fibonacci, "fibonacci")
        self.client.wait_for_server()
        goal = Fibonacci.Goal(order=20)
        self.client.send_goal_async(goal, self.feedback).add_done_callback(self.accepted)

    def accepted(self, future):
        self.goal = future.result()
        self.goal.get_result_async().add_done_callback(self.done)

    def feedback(self, _):
        self.count += 1
        print("feedback", self.count)
        if self.count == 5:
            self.goal.cancel_goal_async()

    def done(self, future):
        answer = future.result()
        print(f"status {answer.status}, {len(answer.result.sequence)} numbers")
        rclpy.shutdown()


def main():
    rclpy.init()
    rclpy.spin(Client())


if __name__ == "__main__":
    main()
