"""Drives ahead until something is near, with a rate in its execute callback."""

import math

import rclpy
from bt_mission_interfaces.action import ExploreForward
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


class ExploreServer(Node):
    def __init__(self):
        super().__init__("course_explore_server")
        self.group = ReentrantCallbackGroup()
        self.ahead = self.x = self.y = None
        self.create_subscription(
            LaserScan, "scan", self.scan, qos_profile_sensor_data, callback_group=self.group
        )
        self.create_subscription(Odometry, "odom", self.odom, 10, callback_group=self.group)
        self.command = self.create_publisher(TwistStamped, "cmd_vel", 10)
        self.server = ActionServer(
            self,
            ExploreForward,
            "course_explore",
            execute_callback=self.execute,
            goal_callback=self.goal,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            callback_group=self.group,
        )

    def scan(self, message):
        near = [*message.ranges[:20], *message.ranges[-20:]]
        self.ahead = min((r for r in near if r > message.range_min), default=math.inf)

    def odom(self, message):
        self.x, self.y = message.pose.pose.position.x, message.pose.pose.position.y

    def goal(self, request):
        valid = 0 < request.fwd_velocity <= 0.26 and request.stopping_distance > 0.2
        return GoalResponse.ACCEPT if valid else GoalResponse.REJECT

    def drive(self, speed):
        message = TwistStamped()
        message.header.stamp = self.get_clock().now().to_msg()
        message.twist.linear.x = speed
        self.command.publish(message)

    def execute(self, goal):
        rate = self.create_rate(10)
        while self.ahead is None or self.x is None:
            rate.sleep()
        start = self.x, self.y
        result = ExploreForward.Result()
        while self.ahead > goal.request.stopping_distance:
            if goal.is_cancel_requested:
                self.drive(0.0)
                goal.canceled()
                return result
            self.drive(goal.request.fwd_velocity)
            result.total_distance_travelled = math.dist(start, (self.x, self.y))
            feedback = ExploreForward.Feedback()
            feedback.current_distance_travelled = result.total_distance_travelled
            goal.publish_feedback(feedback)
            rate.sleep()
        self.drive(0.0)
        goal.succeed()
        return result


def main():
    rclpy.init()
    node = ExploreServer()
    executor = MultiThreadedExecutor()
    executor.add_node(node)
    try:
        executor.spin()
    except KeyboardInterrupt:
        node.get_logger().info("stopping")
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
