"""Facts about servers on a robot that listens for one type of command, for both, or not at all."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from bt_mission_interfaces.action import CameraSweep, Turn
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.action import ActionClient
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from sensor_msgs.msg import LaserScan

from action_servers.core.maneuver import ErrorCode
from action_servers.robot_io.base import COMMAND_TYPES, PLAIN, STAMPED, Listeners
from action_servers.server.node import ServerOptions, ServersNode
from bt_mission.base.dds.liveliness import RECORDER
from bt_mission.robots.model import load_robot
from tests.support.rig import Rig
from tests.support.robot_node import BEST_EFFORT, PERIOD_NS, START_NS

STRING = "std_msgs/msg/String"


@pytest.mark.parametrize(
    ("settled", "looks"),
    [
        ("auto", [([STAMPED, STAMPED], None)]),
        ("auto", [([PLAIN], None)]),
        ("auto", [([], "/cmd_vel has no subscriber; is the robot's bringup running?")]),
        ("auto", [([PLAIN, STAMPED], "both TwistStamped and Twist are listened for on /cmd_vel")]),
        ("auto", [([STRING], f"/cmd_vel must be TwistStamped or Twist, but {STRING} is listened")]),
        (
            "auto",
            [
                ([STAMPED], None),
                ([PLAIN], "/cmd_vel is subscribed as Twist, but TwistStamped is sent"),
                ([STAMPED], None),
            ],
        ),
        (
            "plain",
            [([STAMPED], "/cmd_vel is subscribed as TwistStamped, but Twist is"), ([PLAIN], None)],
        ),
    ],
    ids=["stamped", "plain", "nobody", "both", "another type", "changes later", "settled"],
)
def test_the_type_is_the_one_that_is_listened_for(settled, looks):
    """The first that is found stays; what does not fit it is a fault, until it does."""
    listeners = Listeners("/cmd_vel", *([settled] if settled != "auto" else []))
    fitting = [types[0] for types, reason in looks if reason is None]
    for types, reason in looks:
        result = listeners.look(types)
        assert (result is None) if reason is None else str(result).startswith(reason)
    assert listeners.type == (fitting[0] if fitting else None)


class Driver:
    """What a robot's bringup puts on the topics: it stands still, whatever it hears.

    The scan is an LDS-02's: a varying number of rays, limits of 0 and 100 m, NaN where there is
    nothing.
    """

    def __init__(self, node: Node, *types: type) -> None:
        self.node = node
        self.received: list[Any] = []
        self.listen(*types)
        self._scan = self.node.create_publisher(LaserScan, "scan", BEST_EFFORT)
        self._odom = self.node.create_publisher(Odometry, "odom", 10)
        self._count = 0
        self.node.create_timer(0.05, self._tick)

    def listen(self, *types: type) -> None:
        for subscription in tuple(self.node.subscriptions):
            self.node.destroy_subscription(subscription)
        for message_type in types:
            self.node.create_subscription(message_type, "cmd_vel", self.received.append, 10)

    def _tick(self) -> None:
        self._count += 1
        stamp = self.node.get_clock().now().to_msg()
        rays = 230 + self._count % 7
        scan = LaserScan(angle_increment=math.tau / rays, range_min=0.0, range_max=100.0)
        scan.header.stamp = stamp
        scan.ranges = [(2.0, math.nan, 0.0, math.inf, 99.0)[ray % 5] for ray in range(rays)]
        self._scan.publish(scan)
        odometry = Odometry()
        odometry.header.stamp = stamp
        odometry.header.frame_id = "odom"
        odometry.pose.pose.orientation.w = 1.0
        self._odom.publish(odometry)


class Bench(Rig):
    """Servers as `--real` starts them, a robot, and a client."""

    def __init__(self, images: Path, *types: type, **options: Any) -> None:
        super().__init__(start_ns=START_NS)
        self.robot = Driver(self.node("turtlebot3"), *types)
        self.client = self.node("client")
        self.turns = ActionClient(self.client, Turn, "turn")
        self.sweeps = ActionClient(self.client, CameraSweep, "camera_sweep")
        made = ServerOptions(
            image_folder=images, lean=True, context=self.context, command_type="auto", **options
        )
        self.servers = self.add(ServersNode(load_robot("waffle"), made))
        self.steps(12)

    def steps(self, count: int) -> None:
        self.run_for(count * PERIOD_NS / 1e9)

    def send(self, client: ActionClient, goal: Any) -> Any:
        """Send a goal; gives the client's handle."""
        future = client.send_goal_async(goal)
        self.steps(2)
        return future.result()


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Any]:
    """Make a bench: `bench(Twist)`."""
    made: list[Bench] = []

    def make(*types: type, **options: Any) -> Bench:
        made.append(Bench(tmp_path, *types, **options))
        return made[-1]

    yield make
    for node in made:
        node.close()


@pytest.mark.parametrize("message_type", [Twist, TwistStamped])
def test_commands_are_of_the_type_that_the_robot_takes(bench, message_type):
    """Beside an LDS-02 and without a camera or a map."""
    on = bench(message_type)
    handle = on.send(on.turns, Turn.Goal(angle=90.0))
    assert handle.accepted
    assert {type(message) for message in on.robot.received} == {message_type}
    last = on.robot.received[-1]
    assert getattr(last, "twist", last).angular.z > 0.0


def test_nobody_listens(bench, capfd):
    """The goal is refused with the reason, which is logged as an error, once."""
    on = bench()
    assert not on.send(on.turns, Turn.Goal(angle=90.0)).accepted
    on.steps(40)
    output = capfd.readouterr().err
    assert "goal rejected: /cmd_vel has no subscriber" in output
    assert output.count("[ERROR]") == 1


def test_a_recorder_is_nobody(bench, monkeypatch):
    """It hears the commands, but does not drive."""
    on = bench()
    infos = [SimpleNamespace(topic_type=COMMAND_TYPES[0], node_name=RECORDER)]
    monkeypatch.setattr(on.servers, "get_subscriptions_info_by_topic", lambda _: infos)
    assert not on.send(on.turns, Turn.Goal(angle=90.0)).accepted


def test_two_types_at_once_are_refused(bench, capfd, monkeypatch):
    """Whichever were sent, one of the two would not hear. One process cannot play that."""
    on = bench(Twist)
    infos = [SimpleNamespace(topic_type=name, node_name="robot") for name in COMMAND_TYPES]
    monkeypatch.setattr(on.servers, "get_subscriptions_info_by_topic", lambda _: infos)
    assert not on.send(on.turns, Turn.Goal(angle=90.0)).accepted
    assert "goal rejected: both TwistStamped and Twist are listened for" in capfd.readouterr().err


def test_a_robot_that_leaves_ends_the_goal(bench):
    """Aborted within half a second with the reason; the servers live on for its return."""
    on = bench(TwistStamped)
    result = on.send(on.turns, Turn.Goal(angle=90.0)).get_result_async()
    on.robot.listen()
    on.steps(11)
    assert result.done()
    assert result.result().result.error_code == ErrorCode.STOPPED
    assert result.result().result.error_msg.startswith("/cmd_vel has no subscriber")
    on.robot.listen(TwistStamped)
    on.steps(2)
    assert on.send(on.turns, Turn.Goal(angle=90.0)).accepted


def test_without_a_camera_only_camera_actions_are_refused(bench, capfd):
    """With the name of the topic that nobody publishes."""
    on = bench(TwistStamped)
    goal = CameraSweep.Goal(sweep_angle=90.0, image_count=2)
    assert not on.send(on.sweeps, goal).accepted
    assert "nobody publishes /camera/image_raw" in capfd.readouterr().err
    assert on.send(on.turns, Turn.Goal(angle=90.0)).accepted


def test_topics_and_limits_are_parameters(bench):
    """A slower robot on another topic."""
    on = bench(
        TwistStamped,
        parameters={"topics.scan": "/lidar/scan", "max_angular_velocity": 0.5},
    )
    names = {subscription.topic_name for subscription in on.servers.subscriptions}
    assert "/lidar/scan" in names
    with pytest.raises(ParameterException, match="range"):
        bench(TwistStamped, parameters={"max_angular_velocity": 1.9})
