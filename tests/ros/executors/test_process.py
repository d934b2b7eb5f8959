"""A node as a process, without the process: its parameter file, and how it ends."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import rclpy
from rclpy.context import Context
from rclpy.parameter import Parameter

from action_servers.mapping import node as mapper
from action_servers.server.node import NODE_NAME, ServerOptions, ServersNode
from bt_mission.base.diagnostics import InputError
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import find, names
from bt_mission.base.interrupts import InterruptSignals
from bt_mission.robots.model import load_robot
from bt_mission.ros.executors import process as module
from bt_mission.ros.executors.parameter_file import ParameterFile, read_parameters
from bt_mission.ros.executors.process import made_with


def written(folder: Path, text: str, node: str = NODE_NAME) -> ParameterFile:
    """Write a parameter file, and read it."""
    path = folder / "robot.yaml"
    path.write_text(text, encoding="utf-8")
    return read_parameters(path, node)


def servers(context: Context, folder: Path, text: str) -> ServersNode:
    """The servers of a Waffle, with a parameter file."""
    return made_with(
        written(folder, f"/**:\n  ros__parameters:\n    {text}\n"),
        ServerOptions(image_folder=folder, lean=True, context=context),
        lambda options: ServersNode(load_robot("waffle"), options),
    )


def test_nested_names_are_joined_by_dots(tmp_path):
    """As ROS does, from the section of any node and from our own."""
    file = written(
        tmp_path,
        "/**:\n  ros__parameters: {topics: {scan: lidar}, control_rate: 10.0}\n"
        "bt_mission_servers:\n  ros__parameters:\n    frames.base: base\n"
        "bt_mission_arbiter:\n  ros__parameters:\n    timeouts: {joy: 1.0}\n",
    )
    assert file.values == {"topics.scan": "lidar", "control_rate": 10.0, "frames.base": "base"}


@pytest.mark.parametrize(
    ("section", "applies"),
    [
        ("bt_mission_servers:", True),
        ("/robot1/bt_mission_servers:", False),
        ("/**/bt_mission_servers:", True),
        ("/*/bt_mission_servers:", False),
        ("/*:", True),
        ("/**:", True),
        ("bt_mission:", False),
        ("bt_mission_sim:", False),
    ],
)
def test_what_is_for_others_is_skipped(tmp_path, section, applies):
    """As by ROS: sections of `amcl` and of our other nodes; wildcards and namespaces apply."""
    values = "{ros__parameters: {control_rate: 10.0}}"
    others = (
        "amcl: {ros__parameters: {alpha1: 0.2, scan_topic: scan}}\nmap_server: {yaml: a.yaml}\n"
    )
    file = written(tmp_path, f"{others}bt_mission_arbiter: {values}\n{section} {values}\n")
    assert file.values == ({"control_rate": 10.0} if applies else {})
    robot1 = read_parameters(tmp_path / "robot.yaml", NODE_NAME, "/robot1")
    expected = section not in ("bt_mission_servers:", "/*:", "bt_mission:", "bt_mission_sim:")
    assert robot1.values == ({"control_rate": 10.0} if expected else {})


def test_a_namespace_may_be_a_section(tmp_path):
    """Nested, as ROS reads it."""
    written(tmp_path, "robot1: {bt_mission_servers: {ros__parameters: {topics: {scan: laser}}}}\n")
    assert read_parameters(tmp_path / "robot.yaml", NODE_NAME, "robot1").values == {
        "topics.scan": "laser"
    }


def test_a_wildcard_may_name_parameters_of_others(context, tmp_path):
    """They are ignored with a warning, a section of ours must know them."""
    node = servers(context, tmp_path, "{yaw_goal_tolerance_of_nav2: 0.1, control_rate: 10.0}")
    assert node.get_parameter("control_rate").value == 10.0
    node.destroy_node()
    text = "bt_mission_servers:\n  ros__parameters: {yaw_goal_tolerance_of_nav2: 0.1}\n"
    with pytest.raises(InputError, match="no such parameter 'yaw_goal_tolerance_of_nav2'"):
        written(tmp_path, text).refuse_unknown(["control_rate"])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("amcl:\n  ros__parameters: {alpha1: 0.2}\n", "expected '/**:' or 'bt_mission_servers:'"),
        ("bt_mission_server:\n  ros__parameters: {}\n", "robot.yaml:1:1: error: no such node"),
        ("/**:\n  parameters: {a: 1}\n", "expected only 'ros__parameters:'"),
        ("/**:\n  ros__parameters: {a: [1]}\n", "robot.yaml:2:24: error: expected a value for 'a'"),
        ("[]\n", "expected '/**:' or 'bt_mission_servers:'"),
    ],
)
def test_what_is_no_parameter_file_is_refused(tmp_path, text, message):
    """With the place."""
    with pytest.raises(InputError) as caught:
        written(tmp_path, text)
    assert message in str(caught.value)


def test_the_mapper_has_a_section_of_its_own(context, tmp_path):
    """Topics, the frame of the map, and how often it goes out."""
    text = (
        "bt_mission_mapper:\n  ros__parameters:\n"
        "    topics: {scan: laser, map: slam/map}\n    updates_per_map: 2\n"
    )
    node = made_with(
        written(tmp_path, text, mapper.NODE_NAME),
        mapper.MapperOptions(lean=True, context=context),
        lambda options: mapper.MapperNode(load_robot("waffle"), options),
    )
    assert node.count_subscribers("laser") == 1
    assert node.count_publishers("slam/map") == 1
    assert node.get_parameter("updates_per_map").value == 2
    node.destroy_node()


def test_ros_arguments_come_before_the_file(tmp_path):
    """And what neither names has its default."""
    context = Context()
    arguments = ["--ros-args", "-p", "control_rate:=20.0", "-p", "use_sim_time:=true"]
    rclpy.init(context=context, args=arguments)
    node = servers(context, tmp_path, "control_rate: 10.0\n    sensor_timeout: 2.0")
    names = ("control_rate", "sensor_timeout", "hold_after", "topics.scan", "use_sim_time")
    assert [node.get_parameter(name).value for name in names] == [20.0, 2.0, 0.6, "scan", True]
    node.destroy_node()
    context.shutdown()


def test_a_ros_argument_that_does_not_suit_is_an_error_of_ours(tmp_path):
    """Whether or not there is a file."""
    context = Context()
    rclpy.init(context=context, args=["--ros-args", "-p", "control_rate:=1"])
    with pytest.raises(BtMissionError, match="'control_rate' to '1' of type 'INTEGER'"):
        made_with(
            None,
            ServerOptions(image_folder=tmp_path, lean=True, context=context),
            lambda options: ServersNode(load_robot("waffle"), options),
        )
    context.shutdown()


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("contol_rate: 10.0", "3:5", "did you mean 'control_rate'?"),
        ("topics: {scam: x}", "3:14", "did you mean 'topics.scan'?"),
        ("control_rate: 10", "3:19", "write 10.0"),
        ("control_rate: 1000.0", "3:19", "range"),
        ("max_linear_velocity: 0.5", "3:26", "range"),
        ("max_linear_velocity: .nan", "3:26", "expected a finite number, got .nan"),
        ("cmd_vel_type: Twist", "3:19", "must be one of auto, stamped, plain, got 'Twist'"),
        ("topics: {scan: 7}", "3:20", "STRING"),
    ],
)
def test_a_value_that_does_not_suit_is_refused(context, tmp_path, text, place, message):
    """With its place in the file."""
    with pytest.raises(InputError) as caught:
        servers(context, tmp_path, text)
    assert f"robot.yaml:{place}: error:" in str(caught.value)
    assert message in str(caught.value)


def test_a_parameter_is_never_set_to_nan(tmp_path):
    """The ranges of ROS refuse it."""
    context = Context()
    rclpy.init(context=context)
    node = servers(context, tmp_path, "control_rate: 10.0")
    (result,) = node.set_parameters([Parameter("stop_margin", value=math.nan)])
    assert "stop_margin out of range" in result.reason
    node.destroy_node()
    context.shutdown()


@pytest.mark.parametrize("name", ["topics.scan", "control_rate", "frames.map", "cmd_vel_type"])
def test_each_parameter_says_what_it_is(context, tmp_path, name):
    """For whoever lists them."""
    node = servers(context, tmp_path, "control_rate: 10.0")
    descriptor = node.describe_parameter(name)
    assert descriptor.description.endswith(".")
    assert descriptor.read_only
    node.destroy_node()


@pytest.mark.parametrize("name", names("parameters"))
def test_each_shipped_file_suits_its_robot(context, tmp_path, name):
    """No name is unknown, no value out of range."""
    file = read_parameters(find("parameters", name), NODE_NAME)
    assert file.values
    node = made_with(
        file,
        ServerOptions(image_folder=tmp_path, lean=True, context=context, command_type="auto"),
        lambda options: ServersNode(load_robot(name), options),
    )
    assert {key: node.get_parameter(key).value for key in file.values} == file.values
    node.destroy_node()


def test_an_exception_stops_the_robot_before_it_ends_the_process(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As a signal does; the command fails with the cause."""
    events: list[str] = []

    def spin_once(**_: Any) -> None:
        raise ValueError("a defect")

    node: Any = SimpleNamespace(
        is_done=False,
        refuse_conflicts=lambda _: None,
        begin=lambda: events.append("begin"),
        end=lambda why, _: events.append(why.partition(" (")[0]),
    )
    executor = SimpleNamespace(add_node=lambda _: None, spin_once=spin_once)
    monkeypatch.setattr(module, "LiveExecutor", lambda: executor)
    with pytest.raises(ValueError, match="a defect"):
        module._serve(node, InterruptSignals(most=1))
    assert events == ["begin", "ValueError: a defect"]
