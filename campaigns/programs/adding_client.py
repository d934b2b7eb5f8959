"""Asks the service one after the other, and then several times at once."""

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.node import Node


class AddingClient(Node):
    def __init__(self):
        super().__init__("adding_client")
        self.client = self.create_client(AddTwoInts, "add")
        while not self.client.wait_for_service(timeout_sec=1.0):
            self.get_logger().info("service not available, waiting again...")

    def send(self, a, b):
        return self.client.call_async(AddTwoInts.Request(a=a, b=b))


def main():
    rclpy.init()
    node = AddingClient()
    print("go")
    for number in range(2):
        future = node.send(number, 1)
        rclpy.spin_until_future_complete(node, future)
        print("sum", future.result().sum)
    futures = [node.send(number, 10) for number in range(3)]
    for future in futures:
        rclpy.spin_until_future_complete(node, future, timeout_sec=3.0)
        print("sum", future.result().sum)
    late = node.send(1, 1)
    rclpy.spin_until_future_complete(node, late, timeout_sec=0.1)
    print("done" if late.done() else "not yet")
    rclpy.spin_until_future_complete(node, late)
    print("sum", late.result().sum)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
