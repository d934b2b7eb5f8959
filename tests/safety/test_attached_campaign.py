"""The campaign of attached missions whose processes are killed, stopped and restarted."""

from __future__ import annotations

from itertools import product
from typing import Any

import pytest

REPORT: dict[str, Any] = {
    "status": "failure",
    "goals_left_behind": 1,
    "leaves": [{"outcomes": {"succeeded": 1, "aborted": 1}}],
}
NAMED = "orphaned goals: /turn goal 1a2b3c4d of 'turn' (lost)"
SERVERS = "[servers.turn]: goal succeeded"


def test_a_trial_follows_from_its_number(benchmark: Any) -> None:
    """Everything is done to every process in one of the first 200."""
    plan = benchmark("attached_plan").plan
    assert plan(7) == plan(7)
    done = {
        (disturbance.process, disturbance.what)
        for trial in range(200)
        for disturbance in plan(trial).disturbances
    }
    processes = ("executive", "servers", "arbiter", "sim")
    assert done == set(product(processes, ("kill", "stop", "restart")))


def test_a_true_report_is_no_finding(benchmark: Any) -> None:
    """The exit code is that of its status, the orphan is named, a goal succeeded."""
    check = benchmark("attached_trial").check_report
    assert check(REPORT, 1, NAMED, SERVERS) == []


@pytest.mark.parametrize(
    ("code", "output", "servers", "finding"),
    [
        (0, NAMED, SERVERS, "exit code: 0 with failure"),
        (1, "", SERVERS, "orphans: 1 are not named"),
        (1, NAMED, "", "untrue: 1 goals are said to have succeeded, 0 did"),
    ],
)
def test_an_untrue_report_is_a_finding(
    benchmark: Any, code: int, output: str, servers: str, finding: str
) -> None:
    """Each by its own."""
    assert benchmark("attached_trial").check_report(REPORT, code, output, servers) == [finding]


@pytest.mark.process
@pytest.mark.thorough  # the smoke of the campaigns runs another one
def test_a_trial_judges_real_processes(benchmark: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Servers are killed in the midst of a mission: the base stands, the report tells it."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    outcome = benchmark("attached_trial").carry_out(1)
    assert outcome.plan.startswith("run explore_random: kill servers after 7.592 s")
    assert outcome.findings == []
    assert outcome.disturbed == ["kill servers"]
    assert "orphaned goals: " in outcome.reason or "server lost" in outcome.reason
