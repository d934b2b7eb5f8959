"""Missions on this machine: worlds, robots, parallel branches, and types where ROS is there."""

import sys

import pytest

from bt_mission.language.loader import load_text
from bt_mission.sessions.check import check, examine


def said(text, **options):
    """Return the first line of everything that is said of a mission."""
    return [str(fault).splitlines()[0] for fault in check(load_text(text, "m.yaml", **options))]


def test_a_world_or_robot_from_the_command_line_is_told_as_such():
    """There is no line in the file to point at."""
    text = "mission: m\nworld: dqn_stage4\ntree: {wait: 1}"
    (robot, world) = sorted(said(text, world="x", robot="y"))
    assert robot.startswith("--robot: error: no robot 'y' (known: burger, waffle)")
    assert world.startswith("--world: error: no world 'x' (known: ")
    assert said(text) == []


def test_two_branches_that_move_the_base_are_warned_of():
    """The later goal would end the earlier; one that moves and one that waits are fine."""
    text = "mission: m\ntree:\n  parallel:\n    - {turn: {angle: 9}, timeout: 9}\n    - {wait: 1}\n"
    assert said(text) == []
    more = text + "    - sequence: [{camera_sweep: {sweep_angle: 9, image_count: 1}, timeout: 9}]\n"
    (found,) = said(more)
    assert found.startswith("m.yaml:6:7: warning: two branches of a parallel move the base; the ")


def test_without_ros_a_warning_says_what_was_not_checked(monkeypatch):
    """The rest is checked all the same."""
    monkeypatch.setitem(sys.modules, "bt_mission.ros.interface_types", None)
    monkeypatch.delattr("bt_mission.ros.interface_types", raising=False)
    found = said("mission: m\nrobot: x\ntree: {turn: {angel: 9}, timeout: 9}")
    assert len(found) == 2
    assert found[0].startswith("m.yaml: warning: ROS 2 is not there (")
    assert found[0].endswith("so types and fields were not checked; try 'bt-mission doctor'")
    assert found[1].startswith("m.yaml:2:8: error: no robot 'x'")


def test_the_real_types_are_known():
    """A field of the real ExploreForward."""
    (found,) = said("mission: m\ntree: {explore_forward: {velocity: 1}, timeout: 9}")
    assert "(its fields: fwd_velocity, stopping_distance)" in found


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
