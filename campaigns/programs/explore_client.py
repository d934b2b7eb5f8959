"""Has a robot explore, and cancels at a distance, or sees it to the end."""

import sys

import rclpy
from bt_mission_interfaces.action import ExploreForward
from rclpy.action import ActionClient
from rclpy.node import Node


class ExploreClient(Node):
    def __init__(self, action, most):
        super().__init__("course_explore_client")
        self.most, self.cancels = most, False
        self.client = ActionClient(self, ExploreForward, action)

    def send(self, speed, distance):
        self.client.wait_for_server()
        print("send")
        goal = ExploreForward.Goal(fwd_velocity=speed, stopping_distance=distance)
        self.client.send_goal_async(goal, self.feedback).add_done_callback(self.accepted)

    def accepted(self, future):
        self.goal = future.result()
        print("accepted", self.goal.accepted)
        if not self.goal.accepted:
            raise SystemExit(1)
        self.goal.get_result_async().add_done_callback(self.ended)

    def feedback(self, message):
        if message.feedback.current_distance_travelled > self.most and not self.cancels:
            self.cancels = True
            print("far enough")
            self.goal.cancel_goal_async()

    def ended(self, future):
        print("status", future.result().status)
        far = future.result().result.total_distance_travelled
        print("about", round(far, 1))
        rclpy.shutdown()


rclpy.init()
node = ExploreClient(sys.argv[1], float(sys.argv[2]))
node.send(0.2, float(sys.argv[3]))
rclpy.spin(node)
