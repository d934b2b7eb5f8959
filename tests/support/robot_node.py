"""A fake robot on the topics of a TurtleBot3, as ROS sees it."""

from __future__ import annotations

import array
import math
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import PoseStamped, TransformStamped, TwistStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import Image, JointState, LaserScan, Range
from std_msgs.msg import Bool
from tf2_msgs.msg import TFMessage

from bt_mission.base.geometry import Twist2D

PERIOD_NS = 50_000_000
START_NS = 10_000_000_000
BEST_EFFORT = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def pose(x: float, y: float, yaw_deg: float = 0.0) -> PoseStamped:
    """A pose on the map."""
    message = PoseStamped()
    message.header.frame_id = "map"
    message.pose.position.x, message.pose.position.y = x, y
    half = math.radians(yaw_deg) / 2.0
    message.pose.orientation.z, message.pose.orientation.w = math.sin(half), math.cos(half)
    return message


class RobotNode(Node):
    """Puts a fake robot on the topics of a TurtleBot3; it is what moves with virtual time."""

    def __init__(self, fake: Any, context: Context | None, start_ns: int = START_NS) -> None:
        super().__init__(
            "robot", context=context, start_parameter_services=False, enable_rosout=False
        )
        self.fake = fake
        self.fake.time_s = start_ns * 1e-9
        self.command = Twist2D()
        self.commands: list[Twist2D] = []
        self.on_command: Callable[[Twist2D], None] = self.commands.append
        self.silent: set[str] = set()
        self.rays: list[float] | None = None
        """Rays of the scan instead of those that the fake robot sees."""
        self.next_due_ns = start_ns + PERIOD_NS
        self.create_subscription(TwistStamped, "cmd_vel", self._obey, 10)
        self._scan = self.create_publisher(LaserScan, "scan", BEST_EFFORT)
        further = list(fake.robot.all_lidars)[1:]
        self._further = [self.create_publisher(LaserScan, name, BEST_EFFORT) for name in further]
        self._odom = self.create_publisher(Odometry, "odom", 10)
        self._tf = self.create_publisher(TFMessage, "tf", 100)
        limits = fake.robot.moved_joints
        self.joints = dict.fromkeys(limits, 0.0)
        self._wanted = dict(self.joints)
        # Slowly, so that the example of each action takes several seconds.
        self._speeds = {name: (each.max - each.min) / 8 for name, each in limits.items()}
        self._joint_states = self.create_publisher(JointState, "joint_states", 10)
        self.joint_commands: list[JointState] = []
        self.create_subscription(JointState, "joint_commands", self._obey_joints, 10)
        self._bumpers = {
            f"bumper_{name}": self.create_publisher(Bool, f"bumper_{name}", LATCHED)
            for name in fake.robot.bumpers
        }
        self._cliffs = {
            f"range_{name}": self.create_publisher(Range, f"range_{name}", BEST_EFFORT)
            for name, sensor in fake.robot.range_sensors.items()
            if sensor.kind == "cliff"
        }
        self._map = self.create_publisher(OccupancyGrid, "map", LATCHED)
        self.camera = self.create_publisher(Image, "camera/image_raw", 10)
        # Sent with the first scan: what was sent before its reader is there arrives at some time of
        # the wall clock.
        self._map_is_out = False

    def _obey(self, message: TwistStamped) -> None:
        twist = message.twist
        self.command = Twist2D(twist.linear.x, twist.angular.z, twist.linear.y)
        self.on_command(self.command)

    def _obey_joints(self, message: JointState) -> None:
        self.joint_commands.append(message)
        self._wanted.update(zip(message.name, message.position, strict=True))

    def _move_joints(self) -> JointState:
        """Move the joints for a period."""
        message = JointState(name=list(self.joints))
        for name, before in self.joints.items():
            most = self._speeds[name] * PERIOD_NS * 1e-9
            moved = max(-most, min(most, self._wanted[name] - before))
            self.joints[name] = before + moved
            message.velocity.append(moved / (PERIOD_NS * 1e-9))
        message.position = list(self.joints.values())
        return message

    def advance_to(self, time_ns: int) -> None:
        """Move on and publish, if it is time."""
        if time_ns < self.next_due_ns:
            return
        self.fake.move(self.command, PERIOD_NS * 1e-9)
        self.next_due_ns = time_ns + PERIOD_NS
        self.publish(time_ns)

    def publish(self, time_ns: int) -> None:
        """Send what the sensors see."""
        if not self._map_is_out:
            self._map_is_out = True
            self._map.publish(free_map())
        self.fake.time_s = time_ns * 1e-9
        now = self.fake.observe()
        sec, nanosec = divmod(time_ns, 1_000_000_000)
        for topic, publisher in self._bumpers.items():
            if topic not in self.silent:
                publisher.publish(Bool())
        for topic, publisher in self._cliffs.items():
            if topic not in self.silent:
                publisher.publish(Range(range=0.02, max_range=0.08))
        transform = TransformStamped()
        transform.header.frame_id, transform.child_frame_id = "map", "odom"
        for topic, publisher, message in (
            ("scan", self._scan, scan_message(now.scan, self.rays)),
            # What the first lidar sees is enough: it sees all around.
            *(("scan", each, scan_message(now.scan, self.rays)) for each in self._further),
            ("odom", self._odom, odometry_message(now)),
            ("tf", self._tf, TFMessage(transforms=[transform])),
            ("joint_states", self._joint_states, self._move_joints()),
            ("camera", self.camera, Image(height=2, width=3, step=9, encoding="rgb8")),
        ):
            if topic in self.silent:
                continue
            if topic == "camera":
                message.data = bytes(18)
            header = message.transforms[0].header if topic == "tf" else message.header
            header.stamp.sec, header.stamp.nanosec = sec, nanosec
            publisher.publish(message)


def scan_message(scan: Any, rays: list[float] | None = None) -> LaserScan:
    """A scan as the driver sends it."""
    return LaserScan(
        angle_min=scan.angle_min,
        angle_max=math.tau,
        angle_increment=scan.angle_increment,
        range_min=scan.range_min,
        range_max=scan.range_max,
        ranges=array.array("f", scan.ranges.tobytes() if rays is None else rays),
    )


def odometry_message(now: Any) -> Odometry:
    """Odometry as the driver sends it."""
    message = Odometry()
    message.header.frame_id, message.child_frame_id = "odom", "base_footprint"
    message.pose.pose = pose(now.odom.x, now.odom.y, math.degrees(now.odom.yaw)).pose
    message.twist.twist.linear.x = now.velocity.linear
    message.twist.twist.linear.y = now.velocity.lateral
    message.twist.twist.angular.z = now.velocity.angular
    return message


def free_map() -> OccupancyGrid:
    """Six by six metres of free floor around the origin; unknown more than 2.5 m to its right."""
    message = OccupancyGrid()
    message.header.frame_id = "map"
    message.info.resolution = 0.05
    message.info.width = message.info.height = 120
    message.info.origin.position.x = message.info.origin.position.y = -3.0
    message.info.origin.orientation.w = 1.0
    message.data = array.array("b", [-1] * (120 * 10) + [0] * (120 * 110))
    return message
