"""Simulations of processes side by side; each has the robot's topics under the same names."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from typing import Any

import pytest

from bt_mission.scenarios.run import run_scenario
from bt_mission.testing.live_graph import own_domain
from tests.support import side_by_side
from tests.support.project import ROOT

COUNT = 4
PROGRAM = "tests.support.side_by_side"


def found_by(count: int) -> dict[str, Any]:
    """What so many simulations of one domain have found while all were there."""
    with own_domain() as domain:
        one_domain = {"ROS_DOMAIN_ID": str(domain), "OPENBLAS_NUM_THREADS": "1"}
        done = subprocess.run(
            [sys.executable, "-m", PROGRAM, str(count)],
            cwd=ROOT,
            env=os.environ | one_domain | {"PYTHONPATH": str(ROOT)},
            capture_output=True,
            text=True,
            check=True,
        )
    data: dict[str, Any] = json.loads(done.stdout)
    return data


@pytest.mark.thorough
def test_no_simulation_finds_another_or_is_found(tmp_path):
    """Each has its own nodes, publishers and readers; two visible processes have each other.

    None has a port of the domain, so any number of them leaves room for others. The trace of each
    is that of a run by itself: no message of another was taken for its own.
    """
    result = found_by(COUNT)
    assert len(result["stages"]) == COUNT
    for stage in result["stages"]:
        assert stage["found"] == stage["own"]
        assert stage["counts"] == [[1, 1]] * len(side_by_side.TOPICS)
    assert not result["port"]
    for element in result["visible"]:
        assert len(element["found"]) == 2
        assert all(name.startswith("visible_") for name in element["found"])
        assert element["topics"] == ["/parameter_events"]
    path = tmp_path / "it.scenario.yaml"
    mission = "".join(f"  {line}\n" for line in side_by_side.MISSION.splitlines())
    path.write_text(f"scenario: it\nmission:\n{mission}", encoding="utf-8")
    alone = run_scenario(path).report.trace_sha256
    assert {run["trace"] for run in result["stages"]} == {alone}
