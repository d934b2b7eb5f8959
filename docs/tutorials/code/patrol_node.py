"""A node that runs a mission between other work: docs/tutorials/embed.md."""

import rclpy
from nav_msgs.msg import Odometry
from rclpy.node import Node
from std_srvs.srv import Trigger

import bt_mission


class PatrolNode(Node):
    """Drives a round when it is asked to, and counts odometry all the time."""

    def __init__(self):
        super().__init__("patrol")
        self.mission = bt_mission.load("side.yaml")
        self.runner = None
        self.messages = 0
        self.rounds = 0
        self.create_subscription(Odometry, "odom", self.on_odometry, 10)
        self.create_service(Trigger, "start_round", self.on_start)
        self.create_timer(0.5, self.look)

    def on_odometry(self, message):
        self.messages += 1

    def on_start(self, request, response):
        response.success = self.runner is None
        if self.runner is None:
            self.runner = bt_mission.MissionRunner(self, self.mission)
            response.message = "started"
        else:
            response.message = f"a round is {self.runner.status}"
        return response

    def look(self):
        if self.runner is not None and self.runner.is_done:
            self.get_logger().info(f"round {self.rounds}: {self.runner.report().status}")
            self.runner.close()
            self.runner = None
            self.rounds += 1


def main():
    rclpy.init()
    node = PatrolNode()
    node.on_start(Trigger.Request(), Trigger.Response())
    while node.rounds < 1:
        rclpy.spin_once(node)
    print(f"{node.rounds} round, {node.messages > 0=}")
    node.destroy_node()
    rclpy.shutdown()


main()
