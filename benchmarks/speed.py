"""How fast a mission runs on the stage, against bare MuJoCo stepping the same world.

Each round runs the mission once, with sensors and DDS, and then steps the same physics for the
same virtual time with nothing around it, and once more with the scans. All three are measured in
one process, one after another, so that a busy machine slows all of them; the ratios are what
counts. Run it as: python benchmarks/speed.py [MISSION] [--rounds N]
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
from dataclasses import dataclass
from pathlib import Path

import mujoco
from measuring import CpuWatch, figure

from bt_mission.core.robot.model import load_robot
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.sessions.drive import drive
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import START_NS, Stage
from bt_mission.sessions.stage_files import DEFAULT_WORLD
from bt_mission.views.terminal.speech import Speech
from sim.physics.spawn import RobotSpawn
from sim.simulation import Simulation
from sim.world.loader import load_world


@dataclass(frozen=True)
class StageRun:
    """A mission on the stage: seconds, virtual, of the wall and of the thread's processor."""

    virtual_s: float
    wall_s: float
    cpu_s: float
    ticks: int
    callbacks: int


def stage_run(mission_file: Path) -> StageRun:
    """Run the mission."""
    mission = load(mission_file)
    with (
        tempfile.TemporaryDirectory() as folder,
        Stage(mission, image_folder=Path(folder), say=lambda _: None) as stage,
    ):
        watch = CpuWatch()
        (report,) = drive(stage, [Speech()])
        cpu_s, callbacks = watch.elapsed_s, stage.clock.callbacks_served
    if report.status != "success":
        raise SystemExit(f"{mission.name}: {report.status}: {report.reason}")
    return StageRun(report.virtual_s, report.wall_s, cpu_s, report.ticks, callbacks)


def bare_run(mission_file: Path, virtual_s: float, *, scans: bool) -> float:
    """Wall seconds of the same physics for the same virtual time, with or without its scans."""
    mission = load(mission_file)
    world = load_world(mission.world or DEFAULT_WORLD)
    simulation = Simulation(world, [RobotSpawn(load_robot(mission.robot))], seed=mission.seed)
    (robot,) = simulation.robots
    model, data = simulation.physics.model, simulation.physics.data
    steps = round(virtual_s / model.opt.timestep)
    # In motion, as in a mission: wheels that turn and slip cost more than wheels at rest.
    robot.command(0.1, 0.5)
    simulation.advance_to(START_NS + 1_000_000_000)
    every = round(1 / robot.robot.lidar.rate / model.opt.timestep)
    watch = Stopwatch()
    for step in range(steps):
        mujoco.mj_step(model, data)
        if scans and step % every == 0:
            robot.scan(step // every)
    return watch.elapsed_s


def main() -> None:
    """Measure, and print medians with their spread."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("mission", nargs="?", type=Path, default=Path("missions/explore.yaml"))
    parser.add_argument("--rounds", type=int, default=7)
    options = parser.parse_args()
    stage, cpu, bare, scanned, share = [], [], [], [], []
    run = stage_run(options.mission)  # the first run imports and compiles
    virtual_s = run.virtual_s
    for _ in range(options.rounds):
        run = stage_run(options.mission)
        bare_s = bare_run(options.mission, virtual_s, scans=False)
        scans_s = bare_run(options.mission, virtual_s, scans=True)
        stage.append(virtual_s / run.wall_s)
        cpu.append(1000 * run.cpu_s / virtual_s)
        bare.append(virtual_s / bare_s)
        scanned.append(virtual_s / scans_s)
        share.append(scans_s / run.wall_s)
    print(
        f"{options.mission}: {virtual_s:.2f} s virtual, {run.ticks} ticks, "
        f"{run.callbacks} callbacks; {options.rounds} rounds"
    )
    for name, values in (
        ("stage, sensors and DDS included, x real time", stage),
        ("bare mj_step, x real time", bare),
        ("bare mj_step and scans, x real time", scanned),
        ("stage as a share of bare mj_step and scans", share),
    ):
        print(
            f"  {name:48} median {statistics.median(values):8.2f}"
            f"   from {min(values):.2f} to {max(values):.2f}"
        )
    name = options.mission.stem
    figure(f"{name}: stage", stage, "x real time")
    figure(f"{name}: bare mj_step and scans", scanned, "x real time")
    figure(f"{name}: share of bare mj_step and scans", share)
    figure(f"{name}: CPU a virtual second", cpu, "ms")


if __name__ == "__main__":
    main()
