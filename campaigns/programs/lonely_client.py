"""Gives up where there is no server."""

import sys

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node("lonely")
print("start")
client = ActionClient(node, Fibonacci, "nowhere")
if not client.wait_for_server(timeout_sec=1.0):
    print("no server")
service = node.create_client(Trigger, "nobody")
tries = 0
while not service.wait_for_service(timeout_sec=0.5):
    tries += 1
    print("waiting", tries)
    if tries == 3:
        sys.exit(7)
