"""Facts about the servers as a node."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import rclpy
from bt_mission_interfaces.action import CameraSweep
from geometry_msgs.msg import TwistStamped
from PIL import Image as Picture
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from action_servers.core.error_codes import ErrorCode
from action_servers.core.maneuver import ZERO
from action_servers.server.node import ServerOptions, ServersNode


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


def test_a_canceled_sweep_names_what_it_has_taken(bench, goal):
    """The camera is switched off with it."""
    sent = bench.send("camera_sweep")
    bench.until(lambda: bool(sent.feedback) and sent.feedback[-1].current_image == 2)
    bench.cancel("camera_sweep", sent.id)
    bench.steps(2)
    assert sent.status == "canceled"
    assert [Path(path).name for path in sent.result.image_paths] == ["image_01.png", "image_02.png"]
    assert bench.robot.camera.get_subscription_count() == 0


def test_a_new_sweep_does_not_lose_its_camera_to_the_one_it_replaces(bench):
    """The old one switches it off before the new one switches it on."""
    bench.send("camera_sweep")
    bench.steps(3)
    new = bench.send("camera_sweep")
    bench.until(lambda: bool(new.feedback) and new.feedback[-1].current_image == 1)


def test_images_that_cannot_be_stored_end_the_goal_before_the_robot_moves(bench, tmp_path):
    """Code 905, with the reason of the operating system."""
    (tmp_path / "images").write_text("a file in the way")
    sent = bench.send("camera_sweep")
    bench.until(lambda: sent.status is not None)
    assert sent.result.error_code == ErrorCode.STORAGE
    assert "File exists" in sent.result.error_msg
    assert set(bench.commands) == {ZERO}


def test_a_camera_that_sends_nothing_ends_the_goal_before_the_robot_moves(bench):
    """Code 904 after two seconds."""
    bench.robot.silent = {"camera"}
    sent = bench.send("camera_sweep")
    bench.until(lambda: sent.status is not None)
    assert sent.result.error_code == ErrorCode.NO_IMAGE
    assert set(bench.commands) == {ZERO}


def test_a_sweep_is_rejected_where_nobody_publishes_pictures(bench):
    """A robot whose camera driver is not running."""
    bench.robot.destroy_publisher(bench.robot.camera)
    bench.robot.silent = {"camera"}
    sent = bench.send("camera_sweep")
    bench.steps(2)
    assert sent.accepted is False


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


def test_the_stock_executor_serves_them_too(fake, waffle, tmp_path, robot_node):
    """On the wall clock, in one process, until the goal is canceled."""
    context = rclpy.Context()
    rclpy.init(context=context)
    client_node = Node("client", context=context)
    robot = robot_node(fake(waffle), context, client_node.get_clock().now().nanoseconds)
    servers = ServersNode(waffle, ServerOptions(image_folder=tmp_path, context=context))
    robot.create_timer(0.05, lambda: robot.advance_to(robot.get_clock().now().nanoseconds))
    executor = SingleThreadedExecutor(context=context)
    for node in (client_node, robot, servers):
        executor.add_node(node)

    def spin_until(done: Any) -> None:
        for _ in range(3000):
            if done():
                return
            executor.spin_once(timeout_sec=0.5)
        raise AssertionError("nothing came of it")

    client = ActionClient(client_node, CameraSweep, "camera_sweep")
    spin_until(lambda: servers._sensors.observe().scan and servers._sensors.observe().odom)
    feedback: list[Any] = []
    answer = client.send_goal_async(
        CameraSweep.Goal(sweep_angle=90.0, image_count=9), feedback_callback=feedback.append
    )
    spin_until(lambda: feedback and feedback[-1].feedback.current_image == 1)
    result = answer.result().get_result_async()
    cancel = answer.result().cancel_goal_async()
    spin_until(result.done)
    assert len(cancel.result().goals_canceling) == 1
    assert len(result.result().result.image_paths) == 1
    spin_until(lambda: robot.command == ZERO)

    for node in (servers, robot, client_node):
        node.destroy_node()
    executor.shutdown()
    context.shutdown()
