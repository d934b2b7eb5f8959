"""Facts about the ROS arguments that launch files append."""

from __future__ import annotations

import pytest

from bt_mission.cli.main import main, make_parser
from bt_mission.cli.ros_arguments import RosArgumentsError, checked, of_node, split


def test_they_are_taken_out_of_the_command_line():
    """Wherever they stand, up to a double dash."""
    line = [
        "sim",
        "--ros-args",
        "-p",
        "speed:=2.0",
        "--",
        "--seed",
        "3",
        "--ros-args",
        "-r",
        "a:=b",
    ]
    assert split(line) == (["sim", "--seed", "3"], ["-p", "speed:=2.0", "-r", "a:=b"])


@pytest.mark.parametrize("command", ["sim", "servers", "mapper", "arbiter", "serve"])
def test_commands_that_run_a_node_take_them(command):
    """Their help says so."""
    options = make_parser().parse_args([command])
    assert options.takes_ros_args


def test_others_refuse_them(capsys):
    """There would be no node to hand them to."""
    with pytest.raises(SystemExit) as ended:
        main(["check", "mission.yaml", "--ros-args", "-p", "a:=1"])
    assert ended.value.code == 2
    assert "--ros-args" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [(["-p"], "trailing -p"), (["-r", "x"], "'-r x'"), (["--bogus"], "--bogus")],
)
def test_what_ros_cannot_read_is_refused(wrong, reason):
    """With its own reason, without a place in its sources."""
    with pytest.raises(RosArgumentsError) as caught:
        checked(wrong)
    assert reason in str(caught.value)
    assert "/src/" not in str(caught.value)


def test_what_ros_can_read_is_left_as_it_is():
    """Remappings, parameters, a level of the log."""
    given = ["-r", "scan:=laser", "-p", "a:=1", "--log-level", "info"]
    assert checked(given) == tuple(given)


def test_one_node_of_several_is_renamed():
    """The name is for the node that the command is about; a namespace is for all."""
    given = ["-r", "__node:=executive", "-r", "__ns:=/r1"]
    assert of_node(given, "bt_mission") == ("-r", "bt_mission:__node:=executive", "-r", "__ns:=/r1")
