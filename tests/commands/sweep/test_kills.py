"""Parts of a cluster are killed while a sweep runs: nothing is lost, doubled or different."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from bt_mission.commands.sweep.plan import SweepPlan
from bt_mission.scenarios.concrete.base_scenario import BaseChanges, load_base
from bt_mission.scenarios.concrete.ranges import parse_parameter
from bt_mission.scenarios.concrete.worker import ScenarioWorker
from tests.commands.sweep.killed_sweep import KilledSweep

MISSION = """\
mission: turns
world: empty_arena
inputs: {angle: 30}
requirements:
  is slow: always speed < 1
tree:
  repeat: {count: 2}
  do:
    sequence:
      - turn: {angle: $angle}
      - turn: {angle: "uniform(-20, 20)"}
"""
OPTIONS = ("--seeds", "6", "--vary", "angle=30,60")


@pytest.mark.thorough
@pytest.mark.process
def test_worker_scheduler_and_client_are_killed(tmp_path: Path):
    """After all of it the rows are those of a serial run, in this process."""
    mission = tmp_path / "turns.yaml"
    mission.write_text(MISSION)
    sweep = KilledSweep(tmp_path, mission, OPTIONS, random.Random(7))
    rows = sweep.run(["worker", "client", "scheduler"])
    base = load_base(mission, BaseChanges(), [parse_parameter("angle=30,60")])
    plan = SweepPlan(base, (parse_parameter("angle=30,60"),), seeds=range(6))
    with ScenarioWorker(base.bundle) as worker:
        serial = [worker.carry_out(scenario) for scenario in plan.scenarios()]
    reports = [(row.number, row.id, row.outcome, row.trace_sha256) for row in rows]
    assert reports == [(row.number, row.id, row.outcome, row.trace_sha256) for row in serial]
    assert [row.outcome for row in rows] == ["success"] * 12
    assert len({row.trace_sha256 for row in rows}) == 12
    assert len({row.worker for row in rows}) > 2, "no part of it was killed in time"
