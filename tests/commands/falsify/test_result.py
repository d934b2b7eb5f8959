"""What stands in the file of a find, and the sentence that tells it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from bt_mission.base.verdicts import RequirementResult
from bt_mission.base.yaml.document import read_text
from bt_mission.base.yaml.dump import to_yaml
from bt_mission.commands.falsify.candidate import Candidate
from bt_mission.commands.falsify.guide import CLEARANCE, CLEARANCE_FORMULA, FoundFailure
from bt_mission.commands.falsify.result import scenario_data, sentence
from bt_mission.commands.falsify.search import Counterexample
from bt_mission.commands.falsify.session import load_search
from bt_mission.executive.report import FailurePath, Report
from bt_mission.scenarios.concrete.base_scenario import BaseChanges, BaseScenario
from bt_mission.scenarios.concrete.ranges import RangesFile
from bt_mission.scenarios.faults.text import parse_fault
from bt_mission.scenarios.loader import load_scenario
from tests.commands.falsify.conftest import MISSION, row

NO_RANGES = RangesFile()
FAULT = parse_fault("at 3.0: spawn_box 1.0")


def found_in(base: BaseScenario, kind: Any, candidate: Candidate, **changes: Any) -> Counterexample:
    """Return a find."""
    of_it = row(candidate.concrete(base, 0), -0.1)
    return Counterexample(candidate, replace(of_it, **changes), FoundFailure(kind, "drive"))


def data_of(base: BaseScenario, counterexample: Counterexample, folder: Path) -> dict[str, Any]:
    """Return what stands in the file, which can be loaded."""
    folder.mkdir()
    data = scenario_data(base, counterexample, folder)
    file = folder / "it.scenario.yaml"
    file.write_text(to_yaml(data))
    load_scenario(file)
    return data


@pytest.mark.parametrize(
    ("kind", "changes", "expected"),
    [
        ("violated", {}, {"outcome": "any"}),
        ("violated", {"orphaned_goals": 1}, {"outcome": "any", "orphaned_goals": "any"}),
        ("orphaned", {"orphaned_goals": 1}, {"outcome": "any"}),
        ("collision", {"collisions": 2}, {"outcome": "any", "collisions": 0}),
        ("failed", {"outcome": "failure"}, {"outcome": "success"}),
    ],
)
def test_it_expects_what_should_hold(
    base: BaseScenario, tmp_path: Path, kind: str, changes: Any, expected: dict[str, Any]
) -> None:
    """And nothing else, so that it passes once the mission is fixed."""
    result = found_in(base, kind, Candidate(faults=(FAULT,)), **changes)
    data = data_of(base, result, tmp_path / "out")
    assert data["expect"] == expected


def test_what_is_as_in_the_mission_is_left_out(base: BaseScenario, tmp_path: Path) -> None:
    """The limit, too, where the run ends by itself."""
    result = found_in(base, "violated", Candidate(faults=(FAULT,), limit=40.0))
    assert data_of(base, result, tmp_path / "out") == {
        "scenario": "short: violates 'drive'",
        "mission": "../short.yaml",
        "faults": ["at 3.0: spawn_box ahead 1.0"],
        "nature": "usual",
        "expect": {"outcome": "any"},
    }


def test_what_differs_stands_there(base: BaseScenario, tmp_path: Path) -> None:
    """Seed, inputs, start; and the limit that ends the run."""
    values = {"speed": 0.15, "start.x": 0.5, "start.y": 0.0, "start.yaw": 90.0}
    candidate = Candidate(7, values, (), 9.0)
    result = found_in(base, "violated", candidate, outcome="interrupted")
    data = data_of(base, result, tmp_path / "out")
    assert data["inputs"] == {"speed": 0.15}
    assert data["start"] == {"x": 0.5, "y": 0.0, "yaw": 90.0}
    assert (data["seed"], data["limit"]) == (7, 9.0)


def test_worlds_keep_their_names(tmp_path: Path) -> None:
    """Those of the search are files beside the mission, or shipped ones."""
    (tmp_path / "short.yaml").write_text(MISSION)
    (tmp_path / "mine.yaml").write_text("name: mine\nsize: [4, 4]\n")
    ranges = RangesFile(read_text("worlds: [mine.yaml, dqn_stage1]"))
    base = load_search(tmp_path / "short.yaml", BaseChanges(), ranges, None)
    mine = found_in(base, "violated", Candidate(values={"world": "mine.yaml"}))
    assert data_of(base, mine, tmp_path / "out")["world"] == "../mine.yaml"
    other = found_in(base, "violated", Candidate(values={"world": "dqn_stage1"}))
    assert data_of(base, other, tmp_path / "more")["world"].endswith("dqn_stage1.yaml")


def test_a_scenario_keeps_what_it_says(tmp_path: Path) -> None:
    """Its own faults and obstacles, a mission that stands in it; what it expected goes."""
    path = tmp_path / "it.scenario.yaml"
    lines = MISSION.replace("\n", "\n  ").rstrip()
    path.write_text(
        f"scenario: it\nmission:\n  {lines}\nobstacles: [{{at: [1, 1]}}]\n"
        "faults: ['at 2.0: drop scan lasting 1']\nexpect: {outcome: failure}\n"
    )
    changes = BaseChanges(requirements={CLEARANCE: CLEARANCE_FORMULA})
    base = load_search(path, changes, NO_RANGES, "collision")
    result = found_in(base, "collision", Candidate(faults=(FAULT,)), collisions=1)
    data = data_of(base, result, tmp_path / "out")
    assert data["mission"]["mission"] == "short"
    assert data["obstacles"] == [{"at": [1, 1]}]
    assert data["faults"] == ["at 2.0: drop scan lasting 1", "at 3.0: spawn_box ahead 1.0"]
    assert "requirements" not in data


# ---- what breaks a mission, in a sentence ------------------------------------------------------


REPORT = Report(
    mission="short",
    status="success",
    reason="",
    world="empty_arena",
    robot="waffle",
    seed=5,
    virtual_s=20.0,
    wall_s=0.3,
    real_time_factor=60.0,
    ticks=400,
    goals_sent=2,
    goals_left_behind=1,
    collisions=1,
    distance_travelled_m=1.0,
    trace_sha256="0",
    requirements=(
        RequirementResult(
            "keeps its distance", "always clearance > 0.1", "violated", -0.059768, "m", 12.5, 12.3
        ),
    ),
)
FAILED = replace(
    REPORT,
    status="failure",
    reason="'drive' aborted: no scan for 1 s (code 901)",
    failure=FailurePath(("root", "drive"), "0.0", "no scan for 1 s", 9.0),
)
BOX = parse_fault("at 3.0: spawn_box 1.0 left -0.2")


@pytest.mark.parametrize(
    ("failure", "report", "candidate", "expected"),
    [
        (
            FoundFailure("violated", "keeps its distance"),
            REPORT,
            Candidate(faults=(BOX,)),
            (
                "requirement 'keeps its distance' is violated by 0.05977 m at 12.50 s when a box "
                "appears 1 m ahead and 0.2 m to the right at 3 s"
            ),
        ),
        (
            FoundFailure("collision"),
            REPORT,
            Candidate(7, faults=(BOX, parse_fault("at 4.5: drop scan share 0.5 lasting 2"))),
            (
                "the robot touches something when a box appears 1 m ahead and 0.2 m to the right "
                "at 3 s and 'drop scan share 0.5' begins at 4.5 s for 2 s with seed 7"
            ),
        ),
        (
            FoundFailure("orphaned"),
            REPORT,
            Candidate(values={"speed": 0.25, "start.x": 1.0, "start.y": 0.5, "start.yaw": 90.0}),
            "a goal is orphaned: no server confirms the end with speed=0.25 and start=(1, 0.5, 90)",
        ),
        (
            FoundFailure("failed", "drive"),
            FAILED,
            Candidate(),
            (
                "the mission fails at 20.00 s: 'drive' fails ('drive' aborted: no scan for 1 s "
                "(code 901)) without any fault"
            ),
        ),
        (
            FoundFailure("failed", "runs until its limit"),
            replace(REPORT, status="interrupted"),
            Candidate(),
            "the mission has not ended at 20 s without any fault",
        ),
    ],
)
def test_a_sentence(
    failure: FoundFailure, report: Report, candidate: Candidate, expected: str
) -> None:
    """It says what, by how much, when, and under which conditions."""
    assert sentence(failure, report, candidate) == expected
