"""What breaks a mission, in a sentence."""

from __future__ import annotations

from dataclasses import replace

import pytest

from bt_mission.executive.report import FailurePath, Report
from bt_mission.faults.text import parse_fault
from bt_mission.requirements.monitor import RequirementResult
from bt_mission.search.candidate import Candidate
from bt_mission.search.guide import Failure
from bt_mission.search.result import sentence

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
            Failure("violated", "keeps its distance"),
            REPORT,
            Candidate(faults=(BOX,)),
            (
                "requirement 'keeps its distance' is violated by 0.05977 m at 12.50 s when a box "
                "appears 1 m ahead and 0.2 m to the right at 3 s"
            ),
        ),
        (
            Failure("collision"),
            REPORT,
            Candidate(7, faults=(BOX, parse_fault("at 4.5: drop scan share 0.5 lasting 2"))),
            (
                "the robot touches something when a box appears 1 m ahead and 0.2 m to the right "
                "at 3 s and 'drop scan share 0.5' begins at 4.5 s for 2 s with seed 7"
            ),
        ),
        (
            Failure("orphaned"),
            REPORT,
            Candidate(values={"speed": 0.25, "start.x": 1.0, "start.y": 0.5, "start.yaw": 90.0}),
            "a goal is orphaned: no server confirms the end with speed=0.25 and start=(1, 0.5, 90)",
        ),
        (
            Failure("failed", "drive"),
            FAILED,
            Candidate(),
            (
                "the mission fails at 20.00 s: 'drive' fails ('drive' aborted: no scan for 1 s "
                "(code 901)) without any fault"
            ),
        ),
        (
            Failure("failed", "runs until its limit"),
            replace(REPORT, status="interrupted"),
            Candidate(),
            "the mission has not ended at 20 s without any fault",
        ),
    ],
)
def test_a_sentence(failure: Failure, report: Report, candidate: Candidate, expected: str) -> None:
    """It says what, by how much, when, and under which conditions."""
    assert sentence(failure, report, candidate) == expected
