"""The simulator in a process of its own: starts, answers, ends."""

import os
import signal
import subprocess
import sys
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

from bt_mission.core.errors import BtMissionError
from bt_mission.core.robot.model import load_robot
from sim.physics.spawn import RobotSpawn
from sim.ros.live import FASTEST, CommandWatch, SpeedError, check_speed, main
from sim.ros.node import SimOptions
from tests.support.thorough import sample

LIVE = """
import sys
from bt_mission.core.robot.model import load_robot
from sim.physics.spawn import RobotSpawn
from sim.ros.live import main
from sim.ros.node import SimOptions
robots = [RobotSpawn(load_robot("waffle"))]
options = SimOptions(seed=3, camera=False)
sys.exit(main(world="dqn_stage1", robots=robots, options=options, speed=2.0))
"""

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


@pytest.fixture
def live(beside):
    """The simulator, started beside; killed if it does not end by itself."""
    with (
        subprocess.Popen(
            [sys.executable, "-c", LIVE], stderr=subprocess.PIPE, text=True
        ) as process,
        ExitStack() as last,
    ):
        last.callback(process.kill)  # a failed assertion must not wait for it
        yield process
        process.kill()


@pytest.mark.parametrize("number", sample([signal.SIGTERM, signal.SIGINT], every=2))
def test_it_runs_and_ends_cleanly_on_a_signal(beside, live, number):
    """/clock runs, parameters are described, and a signal ends it with 0 and no traceback.

    In a pause it repeats its time, for those that subscribe then.
    """
    node, executor = beside
    clocks: list[Clock] = []
    node.create_subscription(Clock, "clock", clocks.append, 10)
    client = node.create_client(DescribeParameters, "bt_mission_sim/describe_parameters")
    while len(clocks) < 20 or not client.service_is_ready():
        assert live.poll() is None
        executor.spin_once(timeout_sec=0.1)
    asked = client.call_async(DescribeParameters.Request(names=["speed", "world"]))
    executor.spin_until_future_complete(asked)
    speed, world = asked.result().descriptors
    assert (speed.floating_point_range[0].from_value, speed.read_only) == (0.01, False)
    assert (world.description, world.read_only) == ("Name of the world.", True)
    assert clocks[-1].clock.sec >= 1
    pause = node.create_client(SetSimulationState, "bt_mission_sim/set_simulation_state")
    while not pause.service_is_ready():
        executor.spin_once(timeout_sec=0.1)
    request = SetSimulationState.Request()
    request.state.state = SimulationState.STATE_PAUSED
    executor.spin_until_future_complete(pause.call_async(request))
    late: list[Clock] = []
    node.create_subscription(Clock, "clock", late.append, 10)
    while len(late) < 2:
        assert live.poll() is None
        executor.spin_once(timeout_sec=0.1)
    assert late[-1] == late[-2]
    live.send_signal(number)
    _, output = live.communicate()
    assert live.returncode == 0
    assert "Traceback" not in output
    assert "waffle in dqn_stage1, seed 3, speed 2" in output


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"world": "nowhere"}, "no such world"),
        ({"robots": []}, "expected 1 to 16 robots in a world, got 0"),
        ({"speed": 0.0}, "expected a speed from 0.01 to 1000, got 0.0"),
    ],
)
def test_what_cannot_be_started_is_refused(wrong, words):
    """With an error of ours, before there is a node."""
    options = {"world": "dqn_stage1", "robots": [WAFFLE], "options": SimOptions(seed=0)} | wrong
    with pytest.raises(BtMissionError, match=words):
        main(**options)


TWO = """
import sys
from sim.physics.spawn import read
from sim.ros.live import main
from sim.ros.node import SimOptions
robots = [read("one=waffle@-1,0"), read("two=burger@1,0,180")]
options = SimOptions(seed=0, camera=False)
sys.exit(main(world="dqn_stage1", robots=robots, options=options, speed=5.0))
"""


def test_several_robots_live_under_their_names(beside):
    """Scans of both come, from one process with one clock."""
    node, executor = beside
    scans: list[str] = []
    for name in ("one", "two"):
        node.create_subscription(
            LaserScan,
            f"{name}/scan",
            lambda _, name=name: scans.append(name),
            qos_profile_sensor_data,
        )
    with (
        subprocess.Popen([sys.executable, "-c", TWO], stderr=subprocess.PIPE, text=True) as process,
        ExitStack() as last,
    ):
        last.callback(process.kill)  # a failed assertion must not wait for it
        while set(scans) != {"one", "two"}:
            assert process.poll() is None
            executor.spin_once(timeout_sec=0.1)
        process.send_signal(signal.SIGINT)
        _, output = process.communicate()
    assert process.returncode == 0
    assert "one (waffle), two (burger) in dqn_stage1, seed 0, speed 5" in output


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan"), 2 * FASTEST])
def test_a_useless_speed_is_refused(speed):
    """The message gives both bounds."""
    with pytest.raises(SpeedError, match=r"expected a speed from 0\.01 to 1000, got"):
        check_speed(speed)


PATROL = """
import sys
from bt_mission.core.robot.model import load_robot
from sim.physics.spawn import RobotSpawn
from sim.ros.live import main
from sim.ros.node import SimOptions
from tests.support.thorough import sample
from tests.support.thorough import sample
robots = [RobotSpawn(load_robot("waffle"))]
options = SimOptions(seed=0, camera=False)
sys.exit(main(world="dqn_stage1", robots=robots, options=options, ros_args=sys.argv[1:]))
"""


def test_who_commands_in_vain_is_named(beside):
    """A node that publishes Twist where the robot takes TwistStamped; the remapped topic too."""
    node, executor = beside
    node.create_publisher(Twist, "drive", 10)
    remapped = ["-r", "cmd_vel:=drive", "-r", "__node:=world"]
    with (
        subprocess.Popen(
            [sys.executable, "-c", PATROL, *remapped], stderr=subprocess.PIPE, text=True
        ) as process,
        ExitStack() as last,
    ):
        last.callback(process.kill)  # a failed assertion must not wait for it
        stderr = process.stderr
        assert stderr is not None
        output = next(line for line in stderr if "/beside publishes" in line)
        while ("world", "/") not in node.get_node_names_and_namespaces():
            assert process.poll() is None
            executor.spin_once(timeout_sec=0.1)
    assert (
        "[world]: /drive: /beside publishes geometry_msgs/msg/Twist, but the robot takes" in output
    )
    assert "--cmd-vel-type plain" in output


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


@pytest.mark.parametrize(("name", "who"), [("late", "/late"), (None, "a node with unknown name")])
def test_a_node_without_a_name_is_told_of_at_the_second_look(name, who):
    """The graph may learn of a publisher before it learns of its node; each is told of once."""
    unknown = ("_NODE_NAME_UNKNOWN_", "_NODE_NAMESPACE_UNKNOWN_")
    counts, reported = said_at_each_look([unknown, *([(name, "/") if name else unknown] * 3)])
    assert counts == [0, 1, 1, 1]
    assert f"/cmd_vel: {who} publishes geometry_msgs/msg/Twist, but" in reported[0]


def test_another_node_without_a_name_has_a_second_look_of_its_own():
    """Though one before it had none, either, for a while."""
    unknown = ("_NODE_NAME_UNKNOWN_", "_NODE_NAMESPACE_UNKNOWN_")
    assert said_at_each_look([unknown, ("one", "/"), unknown, ("two", "/")])[0] == [0, 1, 1, 2]


def test_commands_of_the_type_that_a_parameter_names_are_taken(beside):
    """As a launch file sets it."""
    node, executor = beside
    commands = node.create_publisher(Twist, "cmd_vel", 10)
    arguments = ["-p", "cmd_vel_type:=plain", "-p", "speed:=4.0", "--log-level", "warn"]
    with (
        subprocess.Popen(
            [sys.executable, "-c", PATROL, *arguments], stderr=subprocess.PIPE, text=True
        ) as process,
        ExitStack() as last,
    ):
        last.callback(process.kill)  # a failed assertion must not wait for it
        while not commands.get_subscription_count():
            assert process.poll() is None
            executor.spin_once(timeout_sec=0.1)
        process.send_signal(signal.SIGINT)
        _, output = process.communicate()
    assert (process.returncode, output) == (0, "")


@pytest.mark.parametrize("given", ["speed:=0.0", "cmd_vel_type:=twist"])
def test_a_parameter_out_of_its_range_is_refused(given):
    """By an error of ours."""
    with pytest.raises(BtMissionError, match=given.partition(":=")[0]):
        main(
            world="dqn_stage1",
            robots=[WAFFLE],
            options=SimOptions(seed=0, camera=False),
            ros_args=["-p", given],
        )
