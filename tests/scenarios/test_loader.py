"""Scenario files: what is read, and what is said of one that is wrong."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.scenarios.faults.planned import AfterStep, AtTime, WhenTrue
from bt_mission.scenarios.loader import ScenarioChanges, examine_scenario, load_scenario
from bt_mission.scenarios.scenario import Expectation

MISSION = """\
mission: turns
world: empty_arena
inputs: {angle: 90}
requirements:
  is slow: always speed < 1
tree:
  turn: {angle: $angle}
  name: turn
  timeout: 20
"""


@pytest.fixture
def scenario(tmp_path: Path) -> Any:
    """Write a scenario beside a mission: ``scenario(text)`` gives its path."""
    (tmp_path / "turns.yaml").write_text(MISSION, encoding="utf-8")

    def write(text: str, *, mission: str = "mission: turns.yaml\n") -> Path:
        path = tmp_path / "it.yaml"
        path.write_text(f"scenario: it\n{mission}{text}", encoding="utf-8")
        return path

    return write


def test_a_scenario_has_what_its_file_says(scenario: Any) -> None:
    """The mission is that of the file beside it."""
    result = load_scenario(
        scenario(
            "description: A turn.\n"
            "seed: 5\n"
            "robot: burger\n"
            "inputs: {angle: 45}\n"
            "start: {x: 1, yaw: 90}\n"
            "obstacles:\n"
            "  - {at: [0.5, 1], size: [10 cm, 0.2, 0.3]}\n"
            "  - {at: [2, 2], radius: 0.1}\n"
            "requirements:\n  turns: 'eventually within 5 s: succeeded(\"turn\")'\n"
            "limit: 60\n"
            "expect: {outcome: failure, reason: lost, failed: turn, after: 1, before: 2.5,\n"
            "  violated: [turns], orphaned_goals: 1, collisions: 0}\n"
        )
    )
    assert (result.name, result.description, result.limit) == ("it", "A turn.", 60)
    assert (result.mission.seed, result.mission.robot) == (5, "burger")
    assert result.mission.inputs["angle"] == 45
    assert result.start == (1.0, 0.0, 90.0)
    assert [fault.text for fault in result.faults] == [
        "at 0.0: spawn_box at (0.5, 1) size (0.1, 0.2, 0.3)",
        "at 0.0: spawn_cylinder at (2, 2) radius 0.1",
    ]
    assert [requirement.name for requirement in result.mission.requirements] == ["is slow", "turns"]
    assert result.expect == Expectation(
        outcome="failure",
        reason="lost",
        failed="turn",
        after=1,
        before=2.5,
        violated=("turns",),
        orphaned_goals=1,
        collisions=0,
    )


def test_faults_are_texts(scenario: Any) -> None:
    """With or without quotes."""
    text = (
        "faults:\n"
        "  - at 5.0: drop scan lasting 2   # for a while\n"
        "  - 'at 5.0: drop scan lasting 2'\n"
        "  - at 5 s: drop scan lasting 2 s\n"
        "  - 'when previously within 1 s: speed > 0.1 and running(\"turn\"): imu_dead'\n"
        "  - after 1: camera_dead\n"
    )
    faults = list(load_scenario(scenario(text)).faults)
    assert {fault.text for fault in faults[:3]} == {"at 5.0: drop scan lasting 2"}
    assert [type(fault.begins) for fault in faults] == [*[AtTime] * 3, WhenTrue, AfterStep]


def test_mission_and_world_can_stand_in_the_file(scenario: Any) -> None:
    """As mappings."""
    inline = "mission:\n  mission: waits\n  tree: {wait: 1}\n"
    result = load_scenario(scenario("world: {name: hall, size: [6, 3]}\n", mission=inline))
    assert result.mission.name == "waits"
    assert result.world is not None
    assert result.world.size == (6, 3)


def test_what_is_said_outside_comes_first(scenario: Any) -> None:
    """As the options of a run."""
    path = scenario("seed: 5\ninputs: {angle: 45}\n")
    result = load_scenario(path, ScenarioChanges(seed=6, set={"angle": "30"}, robot="burger"))
    assert (result.mission.seed, result.mission.robot) == (6, "burger")
    assert dict(result.mission.inputs) == {"angle": 30}


def test_paths_are_from_the_scenario(
    scenario: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever stands in the working folder under the same name."""
    path = scenario("world: hall.yaml\n")
    (tmp_path / "hall.yaml").write_text("name: own\nsize: [4, 4]\n", encoding="utf-8")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "turns.yaml").write_text("mission: other\ntree: {wait: 1}\n", encoding="utf-8")
    (elsewhere / "hall.yaml").write_text("name: other\nsize: [4, 4]\n", encoding="utf-8")
    monkeypatch.chdir(elsewhere)
    result = load_scenario(path)
    assert result.mission.name == "turns"
    assert result.world is not None
    assert result.world.name == "own"


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("sed: 5\n", "3:1", "unknown key 'sed'"),
        ("seed: -1\n", "3:7", "expected at least 0, got the number -1"),
        ("inputs: {angel: 4}\n", "3:17", "unknown input 'angel' (the mission's inputs: angle)"),
        ("inputs: {angle: far}\n", "3:17", "input 'angle' expects a number, got string 'far'"),
        ("start: {x: here}\n", "3:12", "expected a number, got string 'here'"),
        ("world: atlantis\n", "3:8", "'atlantis': no such world"),
        ("world: {name: hall, size: [6]}\n", "3:27", "is missing"),
        ("obstacles: [{at: [1, 2, 3]}]\n", "3:18", "expected 2 numbers in m"),
        ("obstacles: [{size: [1, 1, 1]}]\n", "3:13", "spawn_box: give a place"),
        ("obstacles: [7]\n", "3:13", "expected a mapping such as 'at: [1.0, 0.5]'"),
        ("faults:\n  - at 5: drp scan\n", "4:11", "did you mean 'drop'?"),
        ("faults:\n  - at 5: drop scan lasting 2 m\n", "4:31", "'lasting' is in s (s, ms, min)"),
        ("faults:\n  - {at: 5, drop: {topic: scan}}\n", "4:5", "expected a fault such as 'at"),
        ('faults:\n  - when running("trn"): imu_dead\n', "4:10", "unknown node: 'trn'"),
        ("faults:\n  - at 1: raise_in_leaf trn\n", "4:25", "unknown node 'trn'"),
        ("faults:\n  - at 700: imu_dead\n", "4:5", "700 s is past the limit of the scenario"),
        ("faults:\n  - 3\n", "4:5", "expected a fault such as"),
        ("robot: burger\nfaults:\n  - at 1: camera_dead\n", "5:11", "'burger' has no camera"),
        ("requirements:\n  a: always sped < 1\n", "4:13", "unknown signal 'sped'"),
        ('requirements:\n  a: never failed("trn")\n', "4:12", "unknown node: 'trn'"),
        ("requirements:\n  is slow: never speed > 2\n", "4:3", "has a requirement 'is slow'"),
        ("expect: {outcome: fail}\n", "3:19", "did you mean 'failure'?"),
        ("expect: {reason: 'a('}\n", "3:20", "expected a regular expression"),
        ("expect: {outcome: any, failed: trn}\n", "3:32", "unknown node 'trn'"),
        ("expect: {failed: turn}\n", "3:18", "no node fails where the mission succeeds"),
        ("expect: {before: 5, after: 10}\n", "3:18", "both before 5 s and after 10 s"),
        ("expect: {violated: [is fast]}\n", "3:21", "unknown requirement 'is fast'"),
        ("limit: 0\n", "3:8", "expected more than 0"),
    ],
)
def test_what_is_wrong_has_its_place(scenario: Any, text: str, place: str, message: str) -> None:
    """In the scenario's file, with what to write instead."""
    path = scenario(text)
    result, faults = examine_scenario(path)
    assert result is None
    errors = [str(fault) for fault in faults if fault.severity == "error"]
    assert any(message in error for error in errors), errors
    assert errors[0].startswith(f"{path}:{place}: error: "), errors


@pytest.mark.parametrize(
    ("mission", "message"),
    [
        ("mission: nowhere.yaml\n", "no such mission: 'nowhere.yaml'"),
        ("mission: it.yaml\n", "'it.yaml' is a scenario; expected a mission"),
        ("mission: 5\n", "expected a name, a path or a mapping, got the number 5"),
        ("", "'mission' is missing"),
        ("mission: {mission: m, tree: {wiat: 1}}\n", "unknown node type 'wiat'"),
    ],
)
def test_a_mission_that_is_none_has_its_place(scenario: Any, mission: str, message: str) -> None:
    """Of one that stands in the file, each error in it."""
    path = scenario("", mission=mission)
    with pytest.raises(InputError, match="error") as caught:
        load_scenario(path)
    first = caught.value.diagnostics[0]
    assert message in first.message
    assert first.file == str(path)


def test_several_errors_are_told_at_once(scenario: Any) -> None:
    """In the order of the file."""
    _, faults = examine_scenario(
        scenario("seed: -1\nfaults:\n  - at 5: drp scan\nexpect: {outcome: fail}\n")
    )
    assert [fault.line for fault in faults] == [3, 5, 6]


def test_poses_are_judged_in_the_world_of_the_scenario(tmp_path):
    """A Husky does not fit at the zones of the mission's arena, but in a wider one."""
    fields = "scenario: s\nmission: patrol\nrobot: husky\n"
    narrow, wide = tmp_path / "narrow.scenario.yaml", tmp_path / "wide.scenario.yaml"
    narrow.write_text(fields, encoding="utf-8")
    wide.write_text(fields + "world: wide_arena\n", encoding="utf-8")
    with pytest.raises(InputError, match="the robot does not fit at the goal"):
        load_scenario(narrow)
    assert load_scenario(wide).mission.robot == "husky"
