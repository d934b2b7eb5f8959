"""Sets the parameters of another node, and follows its events."""

import rclpy
from rcl_interfaces.msg import ParameterEvent
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient


def main():
    rclpy.init()
    node = Node("configurer")
    node.create_subscription(
        ParameterEvent,
        "/parameter_events",
        lambda e: [print("event", p.name) for p in e.changed_parameters if "conf" in e.node],
        10,
    )
    client = AsyncParameterClient(node, "configured")
    client.wait_for_services()
    print("go")
    pause = node.create_rate(2)
    del pause
    for name, value in (("speed", -1.0), ("speed", 0.5), ("none", 1), ("name", "done")):
        future = client.set_parameters([Parameter(name, value=value)])
        rclpy.spin_until_future_complete(node, future)
        result = future.result().results[0]
        print(name, value, result.successful, result.reason)
        end = node.get_clock().now() + rclpy.duration.Duration(seconds=0.75)
        while node.get_clock().now() < end:
            rclpy.spin_once(node, timeout_sec=0.1)
    rclpy.shutdown()


main()
