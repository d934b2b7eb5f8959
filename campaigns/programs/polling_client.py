"""Polls futures between calls of spin_once, and gives up after a while."""

import sys
import time

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient
from rclpy.node import Node

rclpy.init()
node = Node("polling_client")
client = ActionClient(node, Fibonacci, "fibonacci")
while not client.wait_for_server(timeout_sec=1.0):
    pass
print("send")
future = client.send_goal_async(Fibonacci.Goal(order=int(sys.argv[1])))
while not future.done():
    rclpy.spin_once(node, timeout_sec=0.1)
goal = future.result()
print("accepted", goal.accepted)
result = goal.get_result_async()
start = time.time()
while rclpy.ok() and not result.done() and time.time() - start < 2.2:
    rclpy.spin_once(node, timeout_sec=0.1)
if result.done():
    print("status", result.result().status)
else:
    print("too late")
    cancel = goal.cancel_goal_async()
    rclpy.spin_until_future_complete(node, cancel)
    print("code", cancel.result().return_code, len(cancel.result().goals_canceling))
    rclpy.spin_until_future_complete(node, result, timeout_sec=5.0)
    print("status", result.result().status if result.done() else "unknown")
node.destroy_node()
rclpy.shutdown()
