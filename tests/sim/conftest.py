"""Simulations and worlds that several tests of the simulator use."""

from collections.abc import Sequence
from typing import Any

import pytest
from bt_mission_interfaces.msg import Collision
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool
from tf2_msgs.msg import TFMessage

from bt_mission.robots.model import RobotModel, SensorsModel, load_robot
from sim.physics.physics import Physics
from sim.physics.spawn import RobotSpawn
from sim.robot.description import SENSORS
from sim.robot.robot import SimulatedRobot
from sim.ros.node import SimNode, SimOptions
from sim.ros.sensor_topics import message_type
from sim.sensors.camera import Camera
from sim.sensors.canvas import NoCameraError
from sim.world.world import World
from tests.support.rig import Rig
from tests.support.simulated import alone

TOPICS = {
    "/clock": Clock,
    "map": OccupancyGrid,
    "tf_static": TFMessage,
    "collisions": Collision,
    "joint_states": JointState,
    "odom": Odometry,
    "tf": TFMessage,
    "ground_truth/odom": Odometry,
    "motors_on": Bool,
    **{sensor.topic: message_type(sensor) for sensor in SENSORS},
}
LATCHED = {"map", "tf_static", "motors_on"}

CONTROL_NS = 50_000_000
"""The period at which a controller commands, 20 Hz."""


@pytest.fixture(scope="session")
def waffle():
    """The default robot."""
    return load_robot("waffle")


@pytest.fixture
def make_world():
    """Makes a world from fields; a wide empty floor unless told otherwise."""

    def make(**fields: object) -> World:
        return World.model_validate({"name": "test", "size": [20, 20], **fields})

    return make


@pytest.fixture
def simulate(waffle, make_world):
    """Makes a simulation of a Waffle in a world of these fields."""

    def simulate(seed: int = 1, props: int = 0, **fields: object) -> SimulatedRobot:
        return alone(make_world(**fields), waffle, seed=seed, props=props)

    return simulate


@pytest.fixture
def equipped(waffle, make_world):
    """Makes a simulation of a Waffle whose sensors have these options, between two walls."""
    between = [
        {"from": [5, -6], "to": [5, 6], "thickness": 0.2},
        {"from": [-6, 1], "to": [6, 1], "thickness": 0.2},
    ]

    def equipped(seed: int = 1, walls: object = between, **options: object) -> SimulatedRobot:
        robot = waffle.with_sensors(SensorsModel.model_validate(options))
        return alone(make_world(walls=walls), robot, seed=seed)

    return equipped


@pytest.fixture
def drive():
    """Drives at a velocity, commanded at 20 Hz, for some seconds; odometry is read as often."""

    def drive(robot: SimulatedRobot, seconds: float, linear: float = 0.0, angular: float = 0.0):
        physics = robot.physics
        end_ns = physics.time_ns + round(seconds * 1e9)
        while physics.time_ns < end_ns:
            robot.command(linear, angular)
            physics.advance_to(min(physics.time_ns + CONTROL_NS, end_ns))
            robot.read_odometry()

    return drive


@pytest.fixture
def render(waffle):
    """Makes cameras that render, a Waffle's unless told otherwise; skips where there is no EGL."""
    made: list[Camera] = []

    def make(physics: Physics, spec: Any = waffle.camera, prefix: str = "") -> Camera:
        try:
            made.append(Camera(physics.model, spec, prefix))
        except NoCameraError as error:
            pytest.skip(str(error))
        return made[-1]

    yield make
    for camera in made:
        camera.close()


class Stage(Rig):
    """A simulated robot and a node that listens to some topics and commands, on one clock."""

    def __init__(
        self, world: World, robots: Sequence[RobotSpawn], *topics: str, **options: Any
    ) -> None:
        super().__init__()
        options = {"seed": 1, "lean": True} | options
        self.sim = self.add(SimNode(world, robots, SimOptions(context=self.context, **options)))
        self.clock.world = self.sim
        self.ear = self.add(Node("ear", context=self.context, namespace=options.get("namespace")))
        self.received: list[tuple[str, Any]] = []
        for topic in topics:
            self.listen(topic)
        self._is_plain = options.get("command_type") == "plain"
        kind = Twist if self._is_plain else TwistStamped
        self.commands = self.ear.create_publisher(kind, "cmd_vel", 10)

    run = Rig.steps_until

    def listen(self, topic: str) -> None:
        """Keep what comes on a topic from now on."""
        reliability, durability = ReliabilityPolicy, DurabilityPolicy
        qos = QoSProfile(
            depth=100,
            reliability=reliability.BEST_EFFORT if topic == "scan" else reliability.RELIABLE,
            durability=durability.TRANSIENT_LOCAL if topic in LATCHED else durability.VOLATILE,
        )
        self.ear.create_subscription(
            TOPICS[topic], topic, lambda message: self.received.append((topic, message)), qos
        )

    def command(self, linear: float, angular: float = 0.0) -> None:
        """Publish a velocity, and see it delivered."""
        message: Any = Twist() if self._is_plain else TwistStamped()
        twist = message if self._is_plain else message.twist
        twist.linear.x, twist.angular.z = linear, angular
        self.commands.publish(message)
        self.clock.run_until_quiet()

    def messages(self, topic: str) -> list[Any]:
        """What has come on a topic."""
        return [message for received, message in self.received if received == topic]


@pytest.fixture
def make_stage(waffle):
    """Makes stages with a Waffle, another robot or several, and takes them down."""
    made: list[Stage] = []

    def make(
        world: World,
        *topics: str,
        robot: RobotModel = waffle,
        robots: Sequence[RobotSpawn] = (),
        **options: Any,
    ) -> Stage:
        made.append(Stage(world, robots or [RobotSpawn(robot)], *topics, **options))
        return made[-1]

    yield make
    for node in made:
        node.close()
