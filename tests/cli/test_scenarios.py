"""Scenarios and faults on the command line: JSON, traces, options; words: transcripts/."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.command_line import CommandLine
from tests.support.project import SCENARIOS
from tests.support.thorough import sample

SCENARIO = """\
scenario: it turns
mission: turns.yaml
faults:
  - at 0.5: kill_server turn
requirements:
  is slow: always speed < 1
expect: {outcome: failure, failed: turn, orphaned_goals: 1}
"""
TURN = "mission: turns\nworld: empty_arena\ntree:\n  turn: {angle: 90}\n  timeout: 20\n"


def test_json_has_the_verdict_beside_the_report_of_the_run(cli: CommandLine) -> None:
    """Options change a scenario and add to it, as they do with a mission."""
    cli.write("turns.yaml", TURN)
    cli.write("it.yaml", SCENARIO)
    report = cli.json("run it.yaml")
    assert report["scenario"] == {"name": "it turns", "passed": True, "differences": []}
    assert report["faults"][0]["fault"] == "at 0.5: kill_server turn"
    assert report["requirements"][0]["verdict"] == "holds"
    cli.write("more.yaml", "requirements:\n  is fast: always speed > 1\n")
    options = "--seed 4 --fault 'at 0.2: imu_dead' --require more.yaml"
    report = cli.json(f"run it.yaml {options}", 1)
    assert report["seed"] == 4
    assert len(report["faults"]) == 2
    assert "requirement is fast: violated" in report["scenario"]["differences"][0]


def test_faults_are_in_json_and_in_the_trace(cli: CommandLine) -> None:
    """The mission reacts: the server dies, and the goal is orphaned."""
    cli.write("turns.yaml", TURN)
    fault = "when speed < 1 and time >= 0.5: kill_server turn"
    report = cli.json(f"run turns.yaml --fault '{fault}' --trace run.trace", 1)
    outcome = {"fault": fault, "began": 0.5, "ended": None, "why": "", "may_not_happen": False}
    assert report["faults"] == [outcome]
    assert report["goals_left_behind"] == 1
    assert '"event": "fault"' in Path("run.trace").read_text("utf-8")


@pytest.mark.parametrize("path", sample(SCENARIOS, 4), ids=lambda path: path.name)
def test_shipped_scenarios_are_found_by_their_names(path: Path, cli: CommandLine) -> None:
    """From any folder."""
    assert "is valid" in cli(f"check scenarios/{path.name}")
