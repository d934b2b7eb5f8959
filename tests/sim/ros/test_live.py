"""The simulator in a process of its own: starts, answers, ends."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import ExitStack
from types import SimpleNamespace
from typing import Any

import pytest
import rclpy
from geometry_msgs.msg import Twist
from rcl_interfaces.srv import DescribeParameters
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from simulation_interfaces.msg import SimulationState
from simulation_interfaces.srv import SetSimulationState

from bt_mission.base.errors import BtMissionError
from bt_mission.robots.model import load_robot
from sim.physics.spawn import RobotSpawn
from sim.ros.live import FASTEST, CommandWatch, main
from sim.ros.node import SimOptions
from tests.support.thorough import sample

PROGRAM = """
import sys
from bt_mission.robots.model import load_robot
from sim.physics.spawn import RobotSpawn, read
from sim.ros.live import main
from sim.ros.node import SimOptions
options = SimOptions(seed=3, camera=False)
start = {{"world": "dqn_stage1", "robots": {robots}, "options": options, "speed": {speed}}}
sys.exit(main(**start, ros_args=sys.argv[1:]))
"""

ALONE = '[RobotSpawn(load_robot("waffle"))]'

pytestmark = pytest.mark.process

WAFFLE = RobotSpawn(load_robot("waffle"))


@pytest.fixture
def beside():
    """A node that hears other processes of this machine."""
    before = os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"]
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    context = Context()
    rclpy.init(context=context)
    node = Node("beside", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    yield node, executor
    executor.shutdown()
    node.destroy_node()
    context.shutdown()
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = before


class Live:
    """A simulator in a process of its own."""

    def __init__(self, process: subprocess.Popen[str], executor: Any) -> None:
        self.process, self._executor = process, executor

    def serve_until(self, is_so: Callable[[], object]) -> None:
        """Serve the node beside it while it lives."""
        while not is_so():
            assert self.process.poll() is None
            self._executor.spin_once(timeout_sec=0.1)

    def end(self, number: int = signal.SIGINT) -> str:
        """End it by a signal, and return what it has written; it ends with 0."""
        self.process.send_signal(number)
        _, output = self.process.communicate()
        assert self.process.returncode == 0
        return output


@pytest.fixture
def start(beside):
    """Starts simulators, and kills what has not ended when the test has."""
    _, executor = beside
    with ExitStack() as stack:

        def start(*ros_args: str, robots: str = ALONE, speed: float = 1.0) -> Live:
            code = PROGRAM.format(robots=robots, speed=speed)
            command = [sys.executable, "-c", code, *ros_args]
            process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
            stack.enter_context(process)
            stack.callback(process.kill)  # a failed assertion must not wait for it
            return Live(process, executor)

        yield start


@pytest.mark.process(always=True)
@pytest.mark.parametrize("number", sample([signal.SIGTERM, signal.SIGINT], every=2))
def test_it_runs_and_ends_cleanly_on_a_signal(beside, start, number):
    """/clock runs, parameters are described, and a signal ends it with 0 and no traceback.

    In a pause it repeats its time, for those that subscribe then.
    """
    node, executor = beside
    live = start(speed=2.0)
    clocks: list[Clock] = []
    node.create_subscription(Clock, "clock", clocks.append, 10)
    client = node.create_client(DescribeParameters, "bt_mission_sim/describe_parameters")
    live.serve_until(lambda: len(clocks) >= 20 and client.service_is_ready())
    asked = client.call_async(DescribeParameters.Request(names=["speed", "world"]))
    executor.spin_until_future_complete(asked)
    speed, world = asked.result().descriptors
    assert (speed.floating_point_range[0].from_value, speed.read_only) == (0.01, False)
    assert (world.description, world.read_only) == ("Name of the world.", True)
    assert clocks[-1].clock.sec >= 1
    pause = node.create_client(SetSimulationState, "bt_mission_sim/set_simulation_state")
    live.serve_until(pause.service_is_ready)
    request = SetSimulationState.Request()
    request.state.state = SimulationState.STATE_PAUSED
    executor.spin_until_future_complete(pause.call_async(request))
    late: list[Clock] = []
    node.create_subscription(Clock, "clock", late.append, 10)
    live.serve_until(lambda: len(late) >= 2)
    assert late[-1] == late[-2]
    output = live.end(number)
    assert "Traceback" not in output
    assert "waffle in dqn_stage1, seed 3, speed 2" in output


@pytest.mark.thorough
def test_several_robots_live_under_their_names(beside, start):
    """Scans of both come, from one process with one clock."""
    node, _ = beside
    scans: set[str] = set()
    for name in ("one", "two"):
        node.create_subscription(
            LaserScan,
            f"{name}/scan",
            lambda _, name=name: scans.add(name),
            qos_profile_sensor_data,
        )
    live = start(robots='[read("one=waffle@-1,0"), read("two=burger@1,0,180")]', speed=5.0)
    live.serve_until(lambda: scans == {"one", "two"})
    assert "one (waffle), two (burger) in dqn_stage1, seed 3, speed 5" in live.end()


def test_who_commands_in_vain_is_named(beside, start):
    """A node that publishes Twist where the robot takes TwistStamped; the remapped topic too."""
    node, _ = beside
    node.create_publisher(Twist, "drive", 10)
    live = start("-r", "cmd_vel:=drive", "-r", "__node:=world")
    output = next(line for line in live.process.stderr if "/beside publishes" in line)
    live.serve_until(lambda: ("world", "/") in node.get_node_names_and_namespaces())
    assert (
        "[world]: /drive: /beside publishes geometry_msgs/msg/Twist, but the robot takes" in output
    )
    assert "--cmd-vel-type plain" in output


@pytest.mark.thorough
def test_commands_of_the_type_that_a_parameter_names_are_taken(beside, start):
    """As a launch file sets it."""
    node, _ = beside
    commands = node.create_publisher(Twist, "cmd_vel", 10)
    live = start("-p", "cmd_vel_type:=plain", "-p", "speed:=4.0", "--log-level", "warn")
    live.serve_until(commands.get_subscription_count)
    assert live.end() == ""


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"world": "nowhere"}, "no such world"),
        ({"robots": []}, "expected 1 to 16 robots in a world, got 0"),
        ({"ros_args": ["-p", "speed:=0.0"]}, "speed"),
        ({"ros_args": ["-p", "cmd_vel_type:=twist"]}, "cmd_vel_type"),
        *(
            ({"speed": speed}, r"expected a speed from 0\.01 to 1000, got")
            for speed in (0.0, -1.0, float("nan"), 2 * FASTEST)
        ),
    ],
)
def test_what_cannot_be_started_is_refused(wrong, words):
    """With an error of ours, before there is a node."""
    options = {"world": "dqn_stage1", "robots": [WAFFLE], "options": SimOptions(seed=0)} | wrong
    with pytest.raises(BtMissionError, match=words):
        main(**options)


def said_at_each_look(names: list[tuple[str, str]]) -> tuple[list[int], list[str]]:
    """How many warnings there were after each look at a publisher of this name, and they."""
    there: list[SimpleNamespace] = []
    reports: list[str] = []
    node: Any = SimpleNamespace(
        command_type="stamped",
        robots=[SimpleNamespace(prefix="")],
        resolve_topic_name=lambda topic: f"/{topic}",
        get_publishers_info_by_topic=lambda _: there,
        get_logger=lambda: SimpleNamespace(warning=reports.append),
    )
    watch, counts = CommandWatch(node), []
    for first, space in names:
        kind = "geometry_msgs/msg/Twist"
        there[:] = [SimpleNamespace(node_name=first, node_namespace=space, topic_type=kind)]
        watch.look()
        counts.append(len(reports))
    return counts, reports


UNKNOWN = ("_NODE_NAME_UNKNOWN_", "_NODE_NAMESPACE_UNKNOWN_")


@pytest.mark.parametrize(
    ("names", "counts", "who"),
    [
        ([UNKNOWN, *[("late", "/")] * 3], [0, 1, 1, 1], "/late"),
        ([UNKNOWN] * 4, [0, 1, 1, 1], "a node with unknown name"),
        ([UNKNOWN, ("one", "/"), UNKNOWN, ("two", "/")], [0, 1, 1, 2], "/one"),
    ],
    ids=["a name that comes late", "no name", "another one without a name for a while"],
)
def test_a_node_without_a_name_is_told_of_at_the_second_look(names, counts, who):
    """The graph may learn of a publisher before it learns of its node; each is told of once."""
    counted, reported = said_at_each_look(names)
    assert counted == counts
    assert f"/cmd_vel: {who} publishes geometry_msgs/msg/Twist, but" in reported[0]
