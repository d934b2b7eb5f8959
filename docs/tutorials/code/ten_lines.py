"""Runs a mission on your own node: docs/tutorials/embed.md."""

import rclpy

import bt_mission

rclpy.init()
node = rclpy.create_node("my_robot")
mission = bt_mission.load("side.yaml", set={"speed": 0.2})
with bt_mission.MissionRunner(node, mission) as runner:
    while not runner.is_done:
        rclpy.spin_once(node, timeout_sec=0.1)
print(runner.report())
rclpy.shutdown()
