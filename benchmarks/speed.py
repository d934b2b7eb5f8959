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
from pathlib import Path

import mujoco

from bt_mission.core.robot.model import load_robot
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.sessions.load import load
from bt_mission.sessions.session import drive
from bt_mission.sessions.stage import START_NS, Stage
from bt_mission.sessions.stage_files import DEFAULT_WORLD
from bt_mission.views.terminal.quiet import Quiet
from sim.simulation import Simulation
from sim.world.loader import load_world


def stage_run(mission_file: Path) -> tuple[float, float, dict[str, int]]:
    """Run the mission; gives virtual seconds, wall seconds of the run, and counts."""
    mission = load(mission_file)
    with (
        tempfile.TemporaryDirectory() as folder,
        Stage(mission, image_folder=Path(folder), say=lambda _: None) as stage,
    ):
        report = drive(stage, Quiet())
        counts = {"callbacks": stage.clock.callbacks_served, "ticks": report.ticks}
    if report.status != "success":
        raise SystemExit(f"{mission.name}: {report.status}: {report.reason}")
    return report.virtual_s, report.wall_s, counts


def bare_run(mission_file: Path, virtual_s: float, *, scans: bool) -> float:
    """Wall seconds of the same physics for the same virtual time, with or without its scans."""
    mission = load(mission_file)
    robot = load_robot(mission.robot)
    simulation = Simulation(load_world(mission.world or DEFAULT_WORLD), robot, seed=mission.seed)
    model, data = simulation.model, simulation.data
    steps = round(virtual_s / model.opt.timestep)
    # In motion, as in a mission: wheels that turn and slip cost more than wheels at rest.
    simulation.command(0.1, 0.5)
    simulation.advance_to(START_NS + 1_000_000_000)
    every = round(1 / robot.lidar.rate / model.opt.timestep)
    watch = Stopwatch()
    for step in range(steps):
        mujoco.mj_step(model, data)
        if scans and step % every == 0:
            simulation.scan(step // every)
    return watch.elapsed_s


def main() -> None:
    """Measure, and print medians with their spread."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("mission", nargs="?", type=Path, default=Path("missions/explore.yaml"))
    parser.add_argument("--rounds", type=int, default=7)
    options = parser.parse_args()
    stage, bare, scanned, share = [], [], [], []
    virtual_s, counts = 0.0, {"ticks": 0, "callbacks": 0}
    stage_run(options.mission)  # the first run imports and compiles
    for _ in range(options.rounds):
        virtual_s, wall_s, counts = stage_run(options.mission)
        bare_s = bare_run(options.mission, virtual_s, scans=False)
        scans_s = bare_run(options.mission, virtual_s, scans=True)
        stage.append(virtual_s / wall_s)
        bare.append(virtual_s / bare_s)
        scanned.append(virtual_s / scans_s)
        share.append(scans_s / wall_s)
    print(
        f"{options.mission}: {virtual_s:.2f} s virtual, {counts['ticks']} ticks, "
        f"{counts['callbacks']} callbacks; {options.rounds} rounds"
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


if __name__ == "__main__":
    main()
