"""Scenarios and fleets that pytest collects, and scenarios that a failing test leaves."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from bt_mission.recording.robots import recorded_robots
from bt_mission.scenarios.run import run_scenario

SCENARIO = """\
scenario: it turns
mission:
  mission: turns
  world: empty_arena
  tree: {{turn: {{angle: 90}}, name: turn, timeout: 20}}
faults:
  - at 0.5: drop imu lasting 0.5
expect: {{outcome: {}}}
"""
FLEET = """\
fleet: two
world: dqn_stage1
robots:
  one:
    mission: {{mission: turns, tree: {{turn: {{angle: 90}}, name: turn, timeout: {}}}}}
    start: {{x: -1}}
  two: {{mission: {{mission: waits, tree: {{wait: 0.5}}}}, start: {{x: 1}}}}
"""


@pytest.mark.parametrize(
    ("kind", "text"), [("scenario", SCENARIO.format("success")), ("fleet", FLEET.format(20))]
)
def test_a_file_is_a_test(pytester: pytest.Pytester, kind: str, text: str) -> None:
    """Its name is that of the file; other YAML is none. It leaves nothing where it passes."""
    pytester.makefile(f".{kind}.yaml", turns=text)
    pytester.makefile(".yaml", other="mission: m\ntree: {wait: 1}\n")
    result = pytester.runpytest("-v")
    result.assert_outcomes(passed=1)
    result.stdout.fnmatch_lines([f"turns.{kind}.yaml::turns PASSED*"])
    assert not list(pytester.path.glob("scenario_results/*"))


@pytest.mark.parametrize(
    ("kind", "text", "place"),
    [
        ("scenario", "scenario: bad\nmission: nowhere.yaml\n", "2:10"),
        ("fleet", "fleet: bad\nrobots: {one: {mission: nowhere.yaml}}\n", "2:25"),
    ],
)
def test_a_file_that_cannot_be_read_fails_with_its_errors(
    pytester: pytest.Pytester, kind: str, text: str, place: str
) -> None:
    """Without a traceback."""
    pytester.makefile(f".{kind}.yaml", bad=text)
    result = pytester.runpytest()
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines([f"*bad.{kind}.yaml:{place}: error: no such mission: *"])
    result.stdout.no_fnmatch_line("*Traceback*")
    result.stdout.no_fnmatch_line("*loader.py*")


def test_scenarios_of_one_name_are_tests_of_their_own(pytester: pytest.Pytester) -> None:
    """As two searches in one project write them."""
    for folder in ("found/turns", "found/turns_2"):
        path = pytester.path / folder
        path.mkdir(parents=True)
        (path / "turns.scenario.yaml").write_text(SCENARIO.format("success"), encoding="utf-8")
    pytester.runpytest().assert_outcomes(passed=2)


def test_a_failure_tells_the_place_and_keeps_the_recording(pytester: pytest.Pytester) -> None:
    """As that of a test in Python: what happened, and what to type."""
    pytester.makefile(".scenario.yaml", turns=SCENARIO.format("failure"))
    result = pytester.runpytest()
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "*turns.scenario.yaml:8:19: error: expected failure, got success, at *",
            "    expect: {outcome: failure}",
            "*turns: success, at *",
            "bt-mission replay scenario_results/*/recording.mcap",
        ]
    )
    assert list(pytester.path.glob("scenario_results/*/recording.mcap"))


def test_a_fleet_that_fails_shows_its_report_and_keeps_the_recording(
    pytester: pytest.Pytester,
) -> None:
    """The report has a line for each robot; the recording is that of all robots."""
    pytester.makefile(".fleet.yaml", pair=FLEET.format(0.5))
    result = pytester.runpytest()
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "*two: failure (1 of 2 missions succeeded)",
            "*  one  turns * failure: 'turn' *",
            "*  two  waits * success",
            "*bt-mission replay scenario_results/*/recording.mcap",
        ]
    )
    result.stdout.no_fnmatch_line("*file_items.py*")
    (recording,) = pytester.path.glob("scenario_results/*/recording.mcap")
    assert recorded_robots(recording) == ["one", "two"]


@pytest.mark.thorough
def test_a_fleet_that_violates_a_requirement_fails(pytester: pytest.Pytester) -> None:
    """Also where all missions succeed; with --mission-record=off nothing is kept."""
    slow = "requirements: {{slow: never turn_rate > 0.1}}, tree"
    pytester.makefile(".fleet.yaml", pair=FLEET.replace("tree", slow, 1).format(20))
    result = pytester.runpytest("--mission-record=off")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*requirement slow: violated*"])
    result.stdout.no_fnmatch_line("*bt-mission replay*")


TESTS = '''
MISSION = """
mission: turns
world: empty_arena
inputs: {angle: 90}
tree:
  sequence:
    - {turn: {angle: $angle}, timeout: 20}
    - {turn: {angle: -90}, name: back, timeout: 20}
"""
WORLD = "name: hall\\nsize: [5, 5]\\n"

def test_faults(stage):
    box = stage.spawn_box(1.0, left=0.5)
    blind = stage.faults.lidar_dead()
    run = stage.run(MISSION, world=WORLD, seed=3, inputs={"angle": 60})
    run.do(box)
    run.at(0.25, blind)
    run.at(0.75, blind.end)
    run.at(0.5, stage.faults.drop("odom", share=0.5, lasting=0.2))
    run.when(
        lambda s: s.leaf("back").running,
        stage.move_box(box, at=(0.5, 0.8)),
        stage.faults.shove(turn=0.5),
    )
    run.until_done()
    assert not run.report.trace_sha256

def test_cut(stage):
    run = stage.run(MISSION, nature="usual")
    run.until(lambda s: s.t > 1)
    assert not run.stage.trace.sha256

def test_python(stage, scripted_server):
    scripted_server("spin")
    run = stage.run(MISSION)
    run.at(1.0, stage.faults.corrupt("odom", lambda message: None))
    run.until_done()
    assert False
'''


@pytest.fixture
def left(pytester: pytest.Pytester) -> tuple[pytest.RunResult, Path]:
    """Run the failing tests above; gives what they tell, and the folder of what they leave."""
    pytester.makepyfile(test_a=TESTS)
    return pytester.runpytest(), pytester.path / "scenario_results"


def test_a_failing_test_leaves_a_scenario_with_the_same_trace(
    left: tuple[pytest.RunResult, Path],
) -> None:
    """Mission, world, seed, inputs and faults, however they came about; also of a run cut short."""
    result, folder = left
    for name in ("test_faults", "test_cut"):
        path = folder / f"test_a.{name}" / "scenario.yaml"
        result.stdout.fnmatch_lines(
            [f"bt-mission run scenario_results/test_a.{name}/scenario.yaml"]
        )
        lines = (path.parent / "trace.jsonl").read_text(encoding="utf-8").splitlines()
        (matches,) = re.findall(
            r"Trace of the recorded run: ([0-9a-f]{64})\n", path.read_text(encoding="utf-8")
        )
        again = run_scenario(path)
        assert again.passed, str(again)
        assert again.report.trace_sha256 == matches
        assert json.loads(lines[-1])["event"] == "pose"


@pytest.mark.thorough
def test_what_is_no_data_is_named_instead(left: tuple[pytest.RunResult, Path]) -> None:
    """No scenario is written then."""
    result, folder = left
    result.stdout.fnmatch_lines(
        ["  no scenario was written: servers that the test plays: spin; faults.corrupt(*"]
    )
    assert not (folder / "test_a.test_python" / "scenario.yaml").exists()
    assert (folder / "test_a.test_python" / "recording.mcap").exists()


@pytest.mark.thorough
def test_what_a_test_leaves_is_not_collected(left: tuple[pytest.RunResult, Path]) -> None:
    """Or the next session would run it."""
    _, folder = left
    assert not list(folder.rglob("*.scenario.yaml"))
