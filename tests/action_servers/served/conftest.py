"""The servers over real rclpy, on the virtual clock, with a kinematic robot on the topics."""

from __future__ import annotations

import array
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import rclpy
from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from bt_mission_interfaces.action import CameraSweep, ExploreForward, Turn
from geometry_msgs.msg import PoseStamped, TransformStamped, TwistStamped
from nav2_msgs.action import FollowWaypoints, NavigateToPose
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.action import ActionClient
from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import Image, LaserScan
from tf2_msgs.msg import TFMessage
from unique_identifier_msgs.msg import UUID

from action_servers.maneuver import ZERO, Twist2D
from action_servers.node import ServersNode
from bt_mission.common.robot import load_robot
from bt_mission.lockstep import LockstepExecutor

PERIOD_NS = 50_000_000
START_NS = 10_000_000_000
BEST_EFFORT = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

TYPES = {
    "explore_forward": ExploreForward,
    "turn": Turn,
    "camera_sweep": CameraSweep,
    "navigate_to_pose": NavigateToPose,
    "follow_waypoints": FollowWaypoints,
}
STATUS = {
    GoalStatus.STATUS_SUCCEEDED: "succeeded",
    GoalStatus.STATUS_CANCELED: "canceled",
    GoalStatus.STATUS_ABORTED: "aborted",
}


def pose(x: float, y: float, yaw_deg: float = 0.0) -> PoseStamped:
    """A pose on the map."""
    message = PoseStamped()
    message.header.frame_id = "map"
    message.pose.position.x, message.pose.position.y = x, y
    half = math.radians(yaw_deg) / 2.0
    message.pose.orientation.z, message.pose.orientation.w = math.sin(half), math.cos(half)
    return message


def goal(name: str, **changes: Any) -> Any:
    """A sound goal of an action that takes several seconds, with changes."""
    fields: dict[str, Any] = {
        "explore_forward": {"fwd_velocity": 0.2, "stopping_distance": 0.5},
        "turn": {"angle": 720.0},
        "camera_sweep": {"sweep_angle": 180.0, "image_count": 6},
        "navigate_to_pose": {"pose": pose(1.5, 0.0)},
        "follow_waypoints": {"poses": [pose(1.0, 0.0), pose(1.5, 0.5)]},
    }[name]
    return TYPES[name].Goal(**(fields | changes))


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
        self.next_due_ns = start_ns + PERIOD_NS
        self.create_subscription(TwistStamped, "cmd_vel", self._obey, 10)
        self._scan = self.create_publisher(LaserScan, "scan", BEST_EFFORT)
        self._odom = self.create_publisher(Odometry, "odom", 10)
        self._tf = self.create_publisher(TFMessage, "tf", 100)
        self._map = self.create_publisher(OccupancyGrid, "map", LATCHED)
        self.camera = self.create_publisher(Image, "camera/image_raw", 10)
        # Sent with the first scan: what was sent before its reader is there arrives at some time of
        # the wall clock.
        self._map_is_out = False

    def _obey(self, message: TwistStamped) -> None:
        self.command = Twist2D(message.twist.linear.x, message.twist.angular.z)
        self.on_command(self.command)

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
        transform = TransformStamped()
        transform.header.frame_id, transform.child_frame_id = "map", "odom"
        for topic, publisher, message in (
            ("scan", self._scan, scan_message(now.scan)),
            ("odom", self._odom, odometry_message(now)),
            ("tf", self._tf, TFMessage(transforms=[transform])),
            ("camera", self.camera, Image(height=2, width=3, step=9, encoding="rgb8")),
        ):
            if topic in self.silent:
                continue
            if topic == "camera":
                message.data = bytes(18)
            header = message.transforms[0].header if topic == "tf" else message.header
            header.stamp.sec, header.stamp.nanosec = sec, nanosec
            publisher.publish(message)


def scan_message(scan: Any) -> LaserScan:
    """A scan as the driver sends it."""
    return LaserScan(
        angle_min=scan.angle_min,
        angle_max=math.tau,
        angle_increment=scan.angle_increment,
        range_min=scan.range_min,
        range_max=scan.range_max,
        ranges=array.array("f", scan.ranges.tobytes()),
    )


def odometry_message(now: Any) -> Odometry:
    """Odometry as the driver sends it."""
    message = Odometry()
    message.header.frame_id, message.child_frame_id = "odom", "base_footprint"
    message.pose.pose = pose(now.odom.x, now.odom.y, math.degrees(now.odom.yaw)).pose
    message.twist.twist.linear.x = now.velocity.linear
    message.twist.twist.angular.z = now.velocity.angular
    return message


def free_map() -> OccupancyGrid:
    """Six by six metres of free floor around the origin."""
    message = OccupancyGrid()
    message.header.frame_id = "map"
    message.info.resolution = 0.05
    message.info.width = message.info.height = 120
    message.info.origin.position.x = message.info.origin.position.y = -3.0
    message.info.origin.orientation.w = 1.0
    message.data = array.array("b", bytes(120 * 120))
    return message


class Sent:
    """One goal, as its client sees it."""

    def __init__(self, name: str, number: int, events: list[Any]) -> None:
        self.name = name
        self.id = UUID(uuid=[number] * 16)
        self.events = events
        self.accepted: bool | None = None
        self.feedback: list[Any] = []
        self.status: str | None = None
        self.result: Any = None

    def answered(self, future: Any) -> None:
        """Take the answer to the goal, and ask for the result."""
        handle = future.result()
        self.accepted = handle.accepted
        if handle.accepted:
            handle.get_result_async().add_done_callback(self.ended)

    def ended(self, future: Any) -> None:
        """Take the result."""
        response = future.result()
        self.status, self.result = STATUS[response.status], response.result
        self.events.append((self.name, self.status))


class Bench:
    """The servers, a fake robot and two clients in one process on one virtual clock.

    The clients are served first, so that a result would overtake a command that was sent after it.
    `events` lists commands and ends in the order in which they arrive.
    """

    def __init__(self, fake: Any, image_folder: Path) -> None:
        self.context = Context()
        rclpy.init(context=self.context)
        options: dict[str, Any] = {
            "context": self.context,
            "start_parameter_services": False,
            "enable_rosout": False,
        }
        self.clients = [Node(f"client_{number}", **options) for number in (1, 2)]
        self.robot = RobotNode(fake, self.context)
        self.servers = ServersNode(
            fake.robot, image_folder=image_folder, lean=True, context=self.context
        )
        self.clock = LockstepExecutor(start_ns=START_NS, world=self.robot, context=self.context)
        for node in (*self.clients, self.robot, self.servers):
            self.clock.add_node(node)
        self.events: list[Any] = []
        self.robot.on_command = self.events.append
        self._actions: dict[tuple[int, str], ActionClient] = {}
        self._sent = 0
        for number in (0, 1):
            for name in TYPES:
                self._client(name, number)
        self.cancels = {
            name: self.clients[0].create_client(CancelGoal, f"{name}/_action/cancel_goal")
            for name in TYPES
        }

    def close(self) -> None:
        """Take everything down."""
        for node in reversed(self.clock.get_nodes()):
            node.destroy_node()
        self.clock.shutdown()
        self.context.shutdown()

    def _client(self, name: str, number: int) -> ActionClient:
        key = (number, name)
        if key not in self._actions:
            self._actions[key] = ActionClient(self.clients[number], TYPES[name], name)
        return self._actions[key]

    def send(self, name: str, message: Any = None, *, client: int = 0) -> Sent:
        """Send a goal; it arrives with the next step."""
        self._sent += 1
        sent = Sent(f"{name} {self._sent}", self._sent, self.events)
        self._client(name, client).send_goal_async(
            goal(name) if message is None else message,
            feedback_callback=lambda message: sent.feedback.append(message.feedback),
            goal_uuid=sent.id,
        ).add_done_callback(sent.answered)
        return sent

    def cancel(self, name: str, goal_id: UUID | None = None) -> Any:
        """Ask for a cancel by goal id, or of all; the answer's future."""
        request = CancelGoal.Request()
        if goal_id is not None:
            request.goal_info.goal_id = goal_id
        return self.cancels[name].call_async(request)

    def steps(self, count: int) -> None:
        """Let some control steps pass."""
        end_ns = self.clock.now_ns + count * PERIOD_NS
        while self.clock.now_ns < end_ns:
            self.clock.step()

    def until(self, done: Callable[[], bool], limit: int = 2000) -> None:
        """Let control steps pass until something holds."""
        for _ in range(limit):
            if done():
                return
            self.steps(1)
        raise AssertionError(f"not within {limit} control steps")

    @property
    def commands(self) -> list[Twist2D]:
        """The commands that reached the robot."""
        return [event for event in self.events if isinstance(event, Twist2D)]

    @property
    def moved(self) -> bool:
        """Whether the robot was ever told to move."""
        return any(command != ZERO for command in self.commands)

    @property
    def before_the_last_end(self) -> Any:
        """What arrived just before the last end of a goal."""
        ends = [index for index, event in enumerate(self.events) if isinstance(event, tuple)]
        return self.events[ends[-1] - 1]


@pytest.fixture
def bench(fake, tmp_path):
    """A bench whose robot has been heard of."""
    made = Bench(fake(load_robot("waffle")), tmp_path / "images")
    made.steps(2)
    yield made
    made.close()


@pytest.fixture
def silent_bench(fake, tmp_path):
    """A bench whose robot has not said anything yet."""
    made = Bench(fake(load_robot("waffle")), tmp_path / "images")
    made.robot.silent = {"scan", "odom", "tf", "camera"}
    made.steps(2)
    yield made
    made.close()


@pytest.fixture(params=list(TYPES))
def name(request):
    """Every action that we serve."""
    return request.param


@pytest.fixture(params=list(TYPES))
def newer(request):
    """Every action that we serve, once more."""
    return request.param


@pytest.fixture(name="goal")
def goal_():
    """Make a sound goal that takes several seconds: `goal(name, **changes)`."""
    return goal


@pytest.fixture(name="pose")
def pose_():
    """Make a pose on the map: `pose(x, y, yaw_deg)`."""
    return pose


@pytest.fixture
def robot_node():
    """Make a fake robot's node: `robot_node(fake, context, start_ns)`."""
    return RobotNode
