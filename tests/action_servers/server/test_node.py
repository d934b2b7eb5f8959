"""Facts about the servers as a node, and as a process."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
import rclpy
from bt_mission_interfaces.action import CameraSweep, Turn
from geometry_msgs.msg import TwistStamped
from lifecycle_msgs.srv import GetState
from nav_msgs.msg import Path as PathMessage
from PIL import Image as Picture
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from action_servers.core.maneuver import ZERO
from action_servers.server.node import ServerOptions, ServersNode
from action_servers.server.topics import answer_as_navigator
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from tests.support.processes import PATIENCE_S
from tests.support.rig import Rig
from tests.support.thorough import sample


def test_a_sweep_writes_png_files_into_a_folder_named_after_time_and_goal(bench, goal, tmp_path):
    """One per picture; the result names folder and files."""
    sent = bench.send("camera_sweep", goal("camera_sweep", sweep_angle=30.0, image_count=3))
    bench.until(lambda: sent.status is not None)
    folder = tmp_path / "images" / "sweep_10.150_01010101"
    assert sent.result.image_path == str(folder)
    assert sent.result.image_paths == [str(folder / f"image_{n:02d}.png") for n in (1, 2, 3)]
    for path in sent.result.image_paths:
        with Picture.open(path) as picture:
            assert picture.size == (3, 2)


def test_a_canceled_sweep_names_what_it_has_taken(bench):
    """In the order taken."""
    sent = bench.send("camera_sweep")
    bench.until(lambda: bool(sent.feedback) and sent.feedback[-1].current_image == 2)
    bench.cancel("camera_sweep", sent.id)
    bench.steps(2)
    assert sent.status == "canceled"
    assert [Path(path).name for path in sent.result.image_paths] == ["image_01.png", "image_02.png"]


def test_a_new_sweep_does_not_lose_its_camera_to_the_one_it_replaces(bench):
    """The old one switches it off before the new one switches it on."""
    bench.send("camera_sweep")
    bench.steps(3)
    new = bench.send("camera_sweep")
    bench.until(lambda: bool(new.feedback) and new.feedback[-1].current_image == 1)


def test_the_default_speed_of_a_turn_is_a_parameter(bench, goal):
    """Within the limits of the robot; it holds from the next goal on."""
    name = "default_turn_velocity"
    (answer,) = bench.servers.set_parameters([Parameter(name, value=0.5)])
    assert answer.successful
    sent = bench.send("turn", goal("turn", angle=90.0))
    bench.until(lambda: sent.status is not None)
    assert max(command.angular for command in bench.commands) == 0.5
    for wrong in (0.0, 5.0):
        (answer,) = bench.servers.set_parameters([Parameter(name, value=wrong)])
        assert not answer.successful


@pytest.mark.parametrize(("name", "value"), [("robot", "waffle"), ("image_folder", "images")])
def test_what_cannot_change_is_read_only(bench, name, value):
    """It is there to be looked at."""
    assert value in bench.servers.get_parameter(name).value
    assert bench.servers.describe_parameter(name).description
    (answer,) = bench.servers.set_parameters([Parameter(name, value="other")])
    assert not answer.successful


def test_lean_node_offers_nothing_but_its_actions_and_switches(bench):
    """No parameter services, no log topic: each costs time in every step of the stage."""
    assert [service.srv_name for service in bench.servers.services] == ["stop", "release"]
    assert {publisher.topic_name for publisher in bench.servers.publishers} == {
        "/cmd_vel",
        "/plan",
        "/total_distance",
        "/parameter_events",
    }


def test_commands_carry_the_time_of_the_control_step(bench, goal):
    """And the frame of the base."""
    stamps: list[Any] = []
    bench.robot.create_subscription(
        TwistStamped, "cmd_vel", lambda message: stamps.append(message.header), 10
    )
    bench.send("turn", goal("turn", angle=90.0))
    bench.steps(3)
    assert [(header.stamp.sec, header.stamp.nanosec) for header in stamps] == [
        (10, 150_000_000),
        (10, 200_000_000),
        (10, 250_000_000),
    ]
    assert {header.frame_id for header in stamps} == {"base_footprint"}


def state(rig: Rig) -> str:
    """What a client hears."""
    client = rig.node("commander").create_client(GetState, "bt_navigator/get_state")
    asked = client.call_async(GetState.Request())
    rig.settle(asked.done)
    return str(asked.result().current_state.label)


@pytest.mark.parametrize(("is_ready", "label"), [(True, "active"), (False, "inactive")])
def test_navigation_is_active_when_it_has_all_that_it_needs(rig, is_ready, label):
    """Programs wait for the word "active" before they send a goal."""
    answer_as_navigator(rig.node("servers"), lambda: is_ready)
    assert state(rig) == label


def test_servers_without_a_map_are_inactive(rig, waffle, tmp_path):
    """A goal would be rejected."""
    rig.add(ServersNode(waffle, ServerOptions(image_folder=tmp_path, context=rig.context)))
    assert state(rig) == "inactive"


MISSION = """\
mission: there
world: empty_arena
tree: {navigate_to_pose: {pose: [0.5, 0.5, 0]}, timeout: 30}
"""


def paths_of(folder: Path, *, listens: bool) -> tuple[list[PathMessage], str]:
    """The paths that somebody hears during a mission, and its trace."""
    paths: list[PathMessage] = []
    with Stage(load(MISSION), image_folder=folder) as stage:
        if listens:
            node = stage.make_node("listener")
            node.create_subscription(PathMessage, "plan", paths.append, 1)
        while not stage.is_done:
            stage.step()
        return paths, stage.trace.sha256


def test_a_path_leads_from_the_robot_to_the_goal(tmp_path: Path) -> None:
    """In the map, with the time at which it was planned; and nothing else changes by it."""
    received, trace = paths_of(tmp_path, listens=True)
    first = received[0]
    begin, end = first.poses[0].pose.position, first.poses[-1].pose.position
    assert (first.header.frame_id, first.header.stamp.sec) == ("map", 1)
    assert abs(begin.x) + abs(begin.y) < 0.1
    assert abs(end.x - 0.5) + abs(end.y - 0.5) < 0.1
    assert paths_of(tmp_path, listens=False) == ([], trace)


class Live:
    """A robot on the wall clock in a context of its own, and other nodes beside it."""

    def __init__(self, make_robot: Callable[..., Any], fake: Any) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        clock = self.add(Node("clock", context=self.context)).get_clock()
        self.robot = self.add(make_robot(fake, self.context, clock.now().nanoseconds))
        self.robot.create_timer(0.05, lambda: self.robot.advance_to(clock.now().nanoseconds))

    def add(self, node: Any) -> Any:
        self.executor.add_node(node)
        return node

    def spin_until(self, done: Callable[[], Any]) -> None:
        for _ in range(3000):  # twenty a second: the process may begin late on a busy machine
            if done():
                return
            self.executor.spin_once(timeout_sec=0.5)
        raise AssertionError("nothing came of it")

    def close(self) -> None:
        for node in self.executor.get_nodes():
            node.destroy_node()
        self.executor.shutdown()
        self.context.shutdown()


@pytest.fixture
def visible(monkeypatch) -> None:
    """Other processes of this machine see the nodes."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")


@pytest.fixture
def live(fake, waffle, robot_node) -> Iterator[Live]:
    """A robot on the wall clock."""
    made = Live(robot_node, fake(waffle))
    yield made
    made.close()


def test_the_stock_executor_serves_them_too(live, waffle, tmp_path):
    """On the wall clock, in one process, until the goal is canceled."""
    servers = live.add(
        ServersNode(waffle, ServerOptions(image_folder=tmp_path, context=live.context))
    )
    client = ActionClient(live.robot, CameraSweep, "camera_sweep")
    live.spin_until(lambda: servers._sensors.observe().scan and servers._sensors.observe().odom)
    feedback: list[Any] = []
    answer = client.send_goal_async(
        CameraSweep.Goal(sweep_angle=90.0, image_count=9), feedback_callback=feedback.append
    )
    live.spin_until(lambda: feedback and feedback[-1].feedback.current_image == 1)
    result = answer.result().get_result_async()
    cancel = answer.result().cancel_goal_async()
    live.spin_until(result.done)
    assert len(cancel.result().goals_canceling) == 1
    assert len(result.result().result.image_paths) == 1
    live.spin_until(lambda: live.robot.command == ZERO)


PROGRAM = """
from pathlib import Path
from action_servers.server.node import main
raise SystemExit(main(robot="waffle", image_folder=Path({folder!r})))
"""


@pytest.mark.thorough
@pytest.mark.process
@pytest.mark.usefixtures("visible")
@pytest.mark.parametrize("number", sample([signal.SIGINT, signal.SIGTERM], every=2))
def test_a_signal_stops_the_robot_ends_the_goal_and_leaves_cleanly(live, tmp_path, number):
    """Zero velocity, an aborted goal with its reason, exit code 0."""
    robot = live.robot
    with (
        subprocess.Popen(
            [sys.executable, "-c", PROGRAM.format(folder=str(tmp_path))],
            env=dict(os.environ),
            stderr=subprocess.PIPE,
            text=True,
        ) as servers,
        ExitStack() as last,
    ):
        last.callback(servers.kill)  # a failed assertion must not wait for it
        client = ActionClient(robot, Turn, "turn")
        live.spin_until(client.server_is_ready)
        handle: Any = None
        while handle is None or not handle.accepted:  # until the servers have heard of the robot
            answer = client.send_goal_async(Turn.Goal(angle=3600.0))
            live.spin_until(answer.done)
            handle = answer.result()
        result = handle.get_result_async()
        live.spin_until(lambda: robot.command.angular == 1.0)
        servers.send_signal(number)
        live.spin_until(result.done)
        live.spin_until(lambda: robot.command == ZERO)
        assert result.result().result.error_msg == (
            f"the action servers were stopped by {number.name}"
        )
        assert servers.wait(timeout=PATIENCE_S) == 0
        assert servers.stderr is not None
        assert "Traceback" not in servers.stderr.read()
    assert robot.command == ZERO
