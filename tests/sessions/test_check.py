"""Missions on this machine: worlds, robots, parallel branches, and types where ROS is there."""

import math
import sys

import pytest

from bt_mission.base.files import names
from bt_mission.base.yaml.document import read_text
from bt_mission.sessions.check import examine
from bt_mission.sessions.goal_checks import with_parameters


def examined(text, **options):
    """Return the first line of every diagnostic of a text, and whether it is a mission."""
    mission, faults = examine(read_text(text, "m.yaml"), **options)
    return mission is not None, [str(fault).splitlines()[0] for fault in faults]


def first_lines(text, **options):
    """Return the first line of every diagnostic of a text."""
    return examined(text, **options)[1]


def test_a_world_or_robot_from_the_command_line_is_told_as_such():
    """There is no line in the file to point at."""
    text = "mission: m\nworld: dqn_stage4\ntree: {wait: 1}"
    (robot, world) = sorted(first_lines(text, world="x", robot="y"))
    known = ", ".join(names("robots"))
    assert robot.startswith(f"--robot: error: unknown robot 'y' (known: {known})")
    assert world.startswith("--world: error: unknown world 'x' (known: ")
    assert first_lines(text) == []


def test_two_branches_that_move_the_base_are_warned_of():
    """The later goal would end the earlier; one that moves and one that waits are fine."""
    text = "mission: m\ntree:\n  parallel:\n    - {turn: {angle: 9}, timeout: 9}\n    - {wait: 1}\n"
    assert first_lines(text) == []
    more = text + "    - sequence: [{camera_sweep: {sweep_angle: 9, image_count: 1}, timeout: 9}]\n"
    (result,) = first_lines(more)
    assert result.startswith("m.yaml:6:7: warning: two branches of a parallel move the base: the ")


@pytest.mark.parametrize(
    ("uses", "part"), [("", ""), ("base", "base"), ("[arm, base]", "base"), ("[]", ""), ("arm", "")]
)
def test_branches_with_actions_of_others_are_compared_by_what_they_use(uses, part):
    """What is not declared is not known, so it is not warned of."""
    dock = "{action: {name: /dock, type: test_msgs/action/Fibonacci, goal: {order: 1}}, timeout: 9"
    text = "mission: m\ntree:\n  parallel:\n    - {turn: {angle: 9}, timeout: 9}\n"
    text += f"    - {dock}{uses and f', uses: {uses}'}}}\n"
    warned = [line for line in first_lines(text) if "two branches" in line]
    assert len(warned) == bool(part)
    assert all(f"move the {part}: the later" in line for line in warned)


def test_without_ros_a_warning_says_what_was_not_checked(monkeypatch):
    """The rest is checked all the same."""
    monkeypatch.setitem(sys.modules, "bt_mission.ros.interface_types", None)
    monkeypatch.delattr("bt_mission.ros.interface_types", raising=False)
    result = first_lines("mission: m\nrobot: x\ntree: {turn: {angel: 9}, timeout: 9}")
    assert len(result) == 2
    assert result[0].startswith("m.yaml: warning: ROS 2 is not available (")
    assert result[0].endswith(
        "so types and fields were not checked; try 'bt-mission doctor' [BT-511]"
    )
    assert result[1].startswith("m.yaml:2:8: error: unknown robot 'x'")


def test_the_real_types_are_known():
    """A field of the real ExploreForward."""
    (result,) = first_lines("mission: m\ntree: {explore_forward: {velocity: 1}, timeout: 9}")
    assert "(its fields: fwd_velocity, stopping_distance)" in result


def test_a_file_is_examined_in_one_go(tmp_path):
    """Loading's faults and the check's, sorted; no mission where there is an error."""
    path = tmp_path / "m.yaml"
    path.write_text(
        "mission: m\nrobot: wafle\ntree:\n  sequence:\n    - wait: -1\n    - turn: {angel: 9}\n",
        encoding="utf-8",
    )
    mission, faults = examine(path)
    assert mission is None
    assert [fault.line for fault in faults] == [2, 5, 6]


def test_a_sound_file_is_examined_with_its_warnings(tmp_path):
    """And given back."""
    path = tmp_path / "m.yaml"
    path.write_text("mission: m\ninputs: {a: 1}\ntree: {turn: {angle: 9}}\n", encoding="utf-8")
    mission, faults = examine(path, seed=3)
    assert mission is not None
    assert mission.seed == 3
    assert [fault.severity for fault in faults] == ["warning", "warning"]
    assert mission.warnings == faults


@pytest.mark.parametrize("text", ["", "- 1", "mission: m", "tree: 5"])
def test_a_file_that_holds_no_mission_is_examined_without_an_exception(tmp_path, text):
    """Empty, no mapping, no tree, no node."""
    path = tmp_path / "m.yaml"
    path.write_text(text, encoding="utf-8")
    mission, faults = examine(path)
    assert mission is None
    assert faults


LEGS = (
    "mission: m\ninputs: {legs: 3, speed: 0.1}\ntree:\n  repeat: {count: $legs}\n  do:\n"
    "    explore_forward: {fwd_velocity: $speed, stopping_distance: 0.5}\n    timeout: 9\n"
)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (
            {"legs": "2.5"},
            (
                "--set:1:6: error: expected an integer of at least 1, got the number 2.5, in "
                "m.yaml:4:19 [BT-302]"
            ),
        ),
        (
            {"legs": "4", "speed": "9"},
            (
                "--set:1:7: error: fwd_velocity must be from 0.01 to 0.26 m/s, got 9: the server "
                "of explore_forward refuses that (limit: max_linear_velocity of the robot "
                "'waffle'), in m.yaml:6:37 [BT-504]"
            ),
        ),
    ],
)
def test_a_value_from_the_command_line_is_blamed_there(values, expected):
    """With the place in the file that it does not suit; the file alone is sound."""
    assert examined(LEGS) == (True, [])
    assert examined(LEGS, set=values) == (False, [expected])


def test_a_fault_of_the_file_stays_one_of_the_file():
    """Also where values are given."""
    result = examined(LEGS.replace("$speed", "7"), set={"legs": "4"})
    assert result[1][0].startswith("m.yaml:6:37: error: fwd_velocity must be from 0.01 to 0.26")


def test_goals_for_the_servers_of_others_are_not_judged():
    """Their limits are not ours."""
    text = "mission: m\ntree: {turn: {angle: 1e6}, timeout: 9}"
    assert examined(text)[0] is False
    assert examined(text, servers=None) == (True, [])


def test_the_parameters_of_servers_that_run_are_the_limits():
    """Also the actions that they offer; the robot is not named, as nobody knows which it is."""
    text = "mission: m\ntree: {turn: {angle: 90, angular_velocity: 1.5}, timeout: 9}"
    slow = {"max_angular_velocity": 0.5, "turn_limit": 45.0}
    result = examined(text, servers=with_parameters(slow, frozenset({"turn"})))[1]
    assert result == [
        (
            "m.yaml:2:22: error: angle must be from -45 to 45 deg, got 90: the server of turn "
            "refuses that (limit: parameter turn_limit of the servers) [BT-504]"
        ),
        (
            "m.yaml:2:44: error: angular_velocity must be from 0.05 to 0.5 rad/s, got 1.5: the "
            "server of turn refuses that (limit: max_angular_velocity of the robot) [BT-504]"
        ),
    ]
    assert examined(text, servers=with_parameters(slow, frozenset({"move"}))) == (True, [])


def test_a_value_that_only_the_run_can_tell_is_not_judged():
    """Neither a drawn one nor one that a node assigns; the field beside it is."""
    text = (
        "mission: m\ntree:\n  sequence:\n    - set: {speed: 9}\n"
        "    - turn: {angle: 'uniform(4000, 5000)', angular_velocity: $speed}\n      timeout: 9\n"
    )
    assert examined(text) == (True, [])
    results = examined(text.replace("'uniform(4000, 5000)'", "4000"))[1]
    assert [line[:30] for line in results] == ["m.yaml:5:21: error: angle must"]


def test_a_pose_is_judged_only_where_the_map_is_known():
    """A robot that makes its map begins with none."""
    text = "mission: m\nworld: nav_arena\ntree: {navigate_to_pose: {pose: [9, 9, 0]}, timeout: 9}"
    assert examined(text)[0] is False
    assert examined(text + "\nmap: unknown\n") == (True, [])
    assert examined(text.replace("world: nav_arena\n", "")) == (True, [])
    odom = "{header: {frame_id: odom}, pose: {position: {x: 9}, orientation: {w: 1}}}"
    assert examined(text.replace("[9, 9, 0]", odom)) == (True, [])


@pytest.mark.parametrize(
    ("angle", "is_warned_of"),
    [
        (math.pi / 2, True),
        (-1.5708, True),
        (0.0, False),
        (0.001, False),
        (3.0, False),
        (90.0, False),
    ],
)
def test_an_angle_that_looks_like_radians_is_warned_of(angle, is_warned_of):
    """Zero and whole numbers are usual in degrees, too."""
    results = first_lines(f"mission: m\ntree: {{turn: {{angle: {angle}}}, timeout: 9}}")
    assert len(results) == is_warned_of
    for line in results:
        assert line.startswith("m.yaml:2:22: warning: 'angle' is in degrees, and ")
        assert "of them in radians" in line
        assert line.endswith("[BT-309]")
