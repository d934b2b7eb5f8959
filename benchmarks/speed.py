"""How fast a mission runs on the stage, against bare MuJoCo stepping the same world.

Each round runs the mission once, with sensors and DDS, and then steps the same physics for the
same virtual time with nothing around it, and once more with the scans. All three are measured in
one process, one after another, so that a busy machine slows all of them; the ratios are what
counts. Run it as: python benchmarks/speed.py [--mission FILE] [--rounds N]
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import mujoco
from measuring import CpuWatch, arguments, figures, ratios, times

from bt_mission.core.robot.model import load_robot
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.executive.report import Report
from bt_mission.sessions.drive import drive
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import START_NS, Stage
from bt_mission.sessions.stage_files import DEFAULT_WORLD
from bt_mission.views.terminal.speech import Speech
from sim.physics.spawn import RobotSpawn
from sim.simulation import Simulation
from sim.world.loader import load_world


def stage_run(mission_file: Path) -> tuple[Report, float, int]:
    """Run the mission; return its report, the CPU time of the thread, s, and the callbacks."""
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
    return report, cpu_s, callbacks


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
    options = arguments(__doc__, mission=Path("missions/explore.yaml"), rounds=7)
    stage, cpu, bare, scanned = [], [], [], []
    report, _, callbacks = stage_run(options.mission)  # the first run imports and compiles
    virtual_s = report.virtual_s
    for _ in range(options.rounds):
        report, cpu_s, callbacks = stage_run(options.mission)
        stage.append(virtual_s / report.wall_s)
        cpu.append(cpu_s / virtual_s)
        bare.append(virtual_s / bare_run(options.mission, virtual_s, scans=False))
        scanned.append(virtual_s / bare_run(options.mission, virtual_s, scans=True))
    name, real_time = options.mission.stem, "x real time"
    figures(
        f"{virtual_s:.2f} s virtual, {report.ticks} ticks, {callbacks} callbacks",
        {
            f"{name}: stage": (stage, real_time),
            f"{name}: bare mj_step": (bare, real_time),
            f"{name}: bare mj_step and scans": (scanned, real_time),
            f"{name}: share of bare mj_step and scans": (ratios(stage, scanned), ""),
            f"{name}: CPU a virtual second": (times(1000, cpu), "ms"),
        },
    )


if __name__ == "__main__":
    main()
