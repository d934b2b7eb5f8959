"""How fast a mission runs on the stage, against bare MuJoCo stepping the same world.

Each round runs the mission once, with sensors and DDS, and then steps the same physics for the
same virtual time with nothing around it, and once more with the scans. All three are measured in
one process, one after another, so that a busy machine slows all of them; the ratios are what
counts. The parts of a step are sampled in further runs.
Run it as: python benchmarks/speed.py [--mission FILE] [--rounds N]
"""

from __future__ import annotations

import signal
import tempfile
from collections import Counter
from pathlib import Path
from types import FrameType

import mujoco
from measuring import CpuWatch, arguments, figures, ratios, times

from bt_mission.base.wall_clock import Stopwatch
from bt_mission.executive.report import Report
from bt_mission.robots.model import load_robot
from bt_mission.sessions.drive import drive
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import START_NS, Stage
from bt_mission.sessions.stage_files import DEFAULT_WORLD
from bt_mission.views.terminal.log_lines import LogLineView
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
        (report,) = drive(stage, [LogLineView()])
        cpu_s, callbacks = watch.elapsed_s, stage.clock.callbacks_served
    if report.status != "success":
        raise SystemExit(f"{mission.name}: {report.status}: {report.reason}")
    return report, cpu_s, callbacks


OUTSIDE = "set-up"
PARTS = {
    "Physics.advance_to": "physics",
    "LidarSensor.numbers": "lidar",
    "Schedule.run": "other sensors, and all messages of the simulation",
    "SensorSubscriptions.observe": "messages that the servers read",
    "Pilot.step": "pilot and maneuvers",
    "Pilot._send_feedback": "feedback",
    "MapperNode._update": "mapper",
    "MissionRunner.tick": "tick of the tree, with its goals",
    "RequirementWatch._step": "requirements",
    "StageRun.record_pose": "trace of the pose",
    "VirtualTimeExecutor.run_until_quiet": "messages and goals served",
    "VirtualTimeExecutor.step": "executor",
    "drive": "loop around the steps",
}
"""The parts of a control step, by the innermost of these functions."""


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


def parts_of(mission_file: Path, rounds: int) -> dict[str, float]:
    """Return the share of the processor time of each part of a step, by samples of the stack."""
    samples: Counter[str] = Counter()

    def sample(_: int, frame: FrameType | None) -> None:
        while frame is not None and frame.f_code.co_qualname not in PARTS:
            frame = frame.f_back
        samples[PARTS[frame.f_code.co_qualname] if frame else OUTSIDE] += 1

    signal.signal(signal.SIGPROF, sample)
    for _ in range(rounds):
        signal.setitimer(signal.ITIMER_PROF, 0.001, 0.001)
        stage_run(mission_file)
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    del samples[OUTSIDE]
    return {part: count / samples.total() for part, count in samples.most_common()}


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
    for part, share in parts_of(options.mission, options.rounds).items():
        print(f"{share:6.1%}  {part}")
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
