"""Turns there and back with the servers of the robot; Ctrl-C cancels."""

import rclpy
from bt_mission_interfaces.action import Turn
from rclpy.action import ActionClient
from rclpy.node import Node

rclpy.init(signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
node = Node("turning_client")
client = ActionClient(node, Turn, "turn")
client.wait_for_server()
print("go")
goal = None
try:
    for angle in (30.0, -30.0, 150.0):
        future = client.send_goal_async(Turn.Goal(angle=angle, angular_velocity=0.5))
        rclpy.spin_until_future_complete(node, future)
        goal = future.result()
        result = goal.get_result_async()
        rclpy.spin_until_future_complete(node, result)
        print(angle, "status", result.result().status, result.result().result.error_code)
except KeyboardInterrupt:
    print("ctrl-c")
    cancel = goal.cancel_goal_async()
    rclpy.spin_until_future_complete(node, cancel)
    print("cancels", len(cancel.result().goals_canceling))
    rclpy.spin_until_future_complete(node, result)
    print("status", result.result().status)
node.destroy_node()
rclpy.shutdown()
