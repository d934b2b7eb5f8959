"""Nav2's actions as they are served here, beside their published definitions."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from tests.support.served import SERVED

PUBLISHED = Path(__file__).with_name("nav2_msgs_1.3.13.txt")
_FIELD = re.compile(r"^(\S+) +(\w+) *(?:=? *([^#\s]+))?", re.MULTILINE)
NAV2 = {name: served for name, served in SERVED.items() if served.action.type.startswith("nav2_")}


def _definitions() -> dict[str, tuple[str, str]]:
    """Return name and text of each published definition, by its file."""
    parts = re.split(r"^== ", PUBLISHED.read_text(encoding="utf-8"), flags=re.MULTILINE)
    definitions = {}
    for part in parts[1:]:
        head, _, text = part.partition("\n")
        file, _, name = head.partition(" ")
        definitions[file] = (name, text)
    return definitions


DEFINITIONS = _definitions()


def _fields(text: str) -> list[list[tuple[str, ...]]]:
    """Return type, name and value of all fields and constants, in order, for each part."""
    return [_FIELD.findall(re.sub(r"#.*", "", part)) for part in text.split("\n---\n")]


@pytest.mark.parametrize(
    "file",
    [
        *(f"action/{served.action.type.rpartition('/')[2]}.action" for served in NAV2.values()),
        "msg/MissedWaypoint.msg",
        "msg/SpeedLimit.msg",
    ],
)
def test_fields_and_constants_are_those_of_the_published_definition(file: str) -> None:
    """Types, names, order, defaults and error codes of goal, result and feedback."""
    root = Path(__file__).parents[2] / "interfaces" / "nav2_msgs"
    ours = _fields((root / file).read_text(encoding="utf-8"))
    assert ours == _fields(DEFINITIONS[file][1])
    assert sum(map(len, ours)) > 2


def test_each_action_has_the_name_that_nav2_gives_it() -> None:
    """A mission for these servers finds the same names on a robot with Nav2."""
    types = {name: served.action.type for name, served in NAV2.items()}
    published = {
        name: f"nav2_msgs/{file.removesuffix('.action')}"
        for file, (name, _) in DEFINITIONS.items()
        if name not in {"", "follow_path", "compute_path_to_pose"}
    }
    assert types == published


def test_declared_codes_are_published_ones_of_the_action_or_of_what_navigation_passes_on() -> None:
    """Each is a constant of the action's result; navigation passes on planner and controller."""
    values: dict[str, set[int]] = {}
    for file, (name, text) in DEFINITIONS.items():
        if name:
            constants = [field for field in _fields(text)[1] if field[1].isupper()]
            values[name] = {int(value) for _, _, value in constants}
            assert file.startswith("action/")
    passed_on = values["follow_path"] | values["compute_path_to_pose"]
    for name in ("navigate_to_pose", "navigate_through_poses"):
        values[name] |= passed_on
    for name, served in NAV2.items():
        assert set(served.action.codes) <= values[name]
        assert bool(served.action.codes) == (name != "wait")


MISSION = """\
mission: all of Nav2's
world: nav_arena
tree:
  sequence:
    - navigate_to_pose: {pose: [1.2, 0.6, 90]}
      timeout: 60
      cancel_when: number_of_recoveries > 5
      outputs: {error_code: code}
    - spin: {target_yaw: -1.57, time_allowance: 20}
      timeout: 30
    - back_up: {target: [-0.1, 0, 0], speed: -0.1, time_allowance: 20}
      timeout: 30
    - drive_on_heading: {target: [0.1, 0, 0], speed: 0.1, time_allowance: 20}
      timeout: 30
      outputs: {total_elapsed_time.sec: seconds}
    - action: {name: wait, type: nav2_msgs/action/Wait, goal: {time: 1}}
      timeout: 5
    - navigate_through_poses: {poses: [[1.0, 0.3, 0], [0.6, 0.0, 0]]}
      timeout: 60
    - follow_waypoints: {poses: [[0.8, 0.1, 0]]}
      timeout: 60
    - check: code == 0
"""


@pytest.mark.thorough
def test_a_mission_of_all_of_them_succeeds_with_our_servers(stage: Any) -> None:
    """Goals, limits, conditions on feedback, outputs."""
    run = stage.run(MISSION, seed=3)
    run.until_done(within=300)
    assert (run.status, run.reason) == ("success", "")


def test_the_same_mission_runs_with_nav2s_names_and_types_alone(
    stage: Any, scripted_server: Any
) -> None:
    """Nothing but an action server of the published type is there for each name."""
    servers = {name: scripted_server(name, served.action.type) for name, served in NAV2.items()}
    run = stage.run(MISSION, seed=3)
    order = re.findall(r"- (?:action: \{name: )?(\w+)[:,] ", MISSION)[: len(servers)]
    names = [name.replace("back_up", "backup") for name in order]
    for name in names:
        run.until(lambda _, name=name: servers[name].goals)
        servers[name].goal.succeed()
    run.until_done()
    assert (run.status, sorted(names)) == ("success", sorted(servers))
    pose = servers["navigate_to_pose"].goals[0].request.pose
    assert (pose.header.frame_id, pose.pose.position.x) == ("map", 1.2)
