"""Missions with IR-SIM, a simulator of others, in place of MuJoCo."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bt_mission.robots.model import load_robot
from bt_mission.scenarios.concrete.base_scenario import BaseChanges, load_base
from bt_mission.scenarios.concrete.worker import ScenarioWorker
from sim.ir_sim import IrSim
from sim.physics.spawn import RobotSpawn
from sim.simulation import Simulation
from sim.world.loader import load_world
from tests.support.command_line import CommandLine

NAME = "sim.ir_sim:IrSim"
TURNS = """\
mission: turns
world: nav_arena
requirements:
  touches nothing: never collisions > 0
  has room: always clearance > 0.1
tree:
  turn: {angle: "uniform(10, 20)"}
  timeout: 30
"""
DRIVES = (
    "mission: m\nworld: nav_arena\ntree:\n  navigate_to_pose: {pose: [0.7, 0, 0]}\n  timeout: 30\n"
)


@pytest.mark.parametrize("robot", ["waffle", "turtlebot4"])
def test_it_sees_and_drives_what_mujoco_does(robot: str) -> None:
    """The same pose within 2 cm after an arc of 0.6 m, the same scan from there within 5 cm."""
    world, model = load_world("dqn_stage4"), load_robot(robot)
    poses, scans = [], []
    for make in (None, IrSim):
        simulation = Simulation(world, [RobotSpawn(model)], seed=2, simulator=make)
        base = simulation.robots[0]
        for _ in range(60):
            base.command(0.2, 0.3)
            simulation.advance_to(simulation.time_ns + 50_000_000)
        poses.append(base.pose)
        scans.append(base.scan(0))
    assert poses[0] == pytest.approx(poses[1], abs=0.02)
    both = np.isfinite(scans[0]) & np.isfinite(scans[1])
    assert both.mean() > 0.5
    assert np.median(np.abs(scans[0][both] - scans[1][both])) < 0.05


def test_a_wall_stops_it_and_counts_as_a_collision() -> None:
    """One collision, with the name of the wall; it can drive away again."""
    simulation = Simulation(
        load_world("nav_arena"), [RobotSpawn(load_robot("burger"))], seed=2, simulator=IrSim
    )
    base = simulation.robots[0]
    for speed, steps in ((0.2, 200), (-0.2, 20)):
        for _ in range(steps):
            base.command(speed, 0.0)
            simulation.advance_to(simulation.time_ns + 50_000_000)
    assert base.collisions == 1
    assert base.clearance().distance > 0.05


def test_a_mission_runs_on_virtual_time_and_repeats(stage: Any) -> None:
    """With its requirements; the same seed gives the same trace, another seed another."""
    traces = []
    for seed in (3, 3, 4):
        run = stage.run(TURNS, seed=seed, simulator=IrSim)
        run.until_done(within=90)
        assert (run.status, run.reason) == ("success", "")
        assert run.check("never collisions > 0")
        traces.append(run.stage.trace.sha256)
    assert traces[0] == traces[1] != traces[2]


def test_scenarios_and_their_workers_name_it(cli: CommandLine) -> None:
    """The class is part of the scenario, so the workers of a sweep use it, too."""
    (cli.folder / "drives.yaml").write_text(DRIVES, encoding="utf-8")
    path = cli.folder / "s.scenario.yaml"
    text = f"scenario: s\nmission: drives.yaml\nsimulator: {NAME}\nnature: usual\n"
    path.write_text(text, encoding="utf-8")
    base = load_base(path, BaseChanges())
    with ScenarioWorker(base.bundle) as worker:
        scenario = base.concrete({}, seed=4)
        assert worker.load(scenario).simulator is not None
        row = worker.carry_out(scenario)
    assert (row.outcome, row.passed, row.reason) == ("success", True, "")


def test_an_option_names_it_too_and_python_can_be_refused(cli: CommandLine) -> None:
    """Without the code of others."""
    (cli.folder / "nap.yaml").write_text("mission: nap\ntree: {wait: 1}\n", encoding="utf-8")
    assert cli.call(f"run nap.yaml --simulator {NAME} --no-python") == 2
    assert "the Python node 'sim.ir_sim:IrSim' is refused [BT-216]" in cli.err


@pytest.mark.thorough
@pytest.mark.parametrize("mission", ["patrol", "explore"])
def test_shipped_missions_succeed(stage: Any, mission: str) -> None:
    """In their own worlds, with the usual differences between runs."""
    for seed in range(3):
        run = stage.run(mission, seed=seed, simulator=IrSim, nature="usual")
        run.until_done(within=400)
        assert (seed, run.status, run.reason) == (seed, "success", "")
