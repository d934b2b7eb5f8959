"""Forks without a change, at random instants of the shipped missions: are they byte-identical?

Run it as: python benchmarks/commands/fork/forks.py [--count 1000] [--seed 0]
    [--missions explore patrol]

Each mission runs and is recorded once; then runs and forks take turns, in this process. Told are
how many forks were the same, and how long a fork takes compared with the run: reading the
recording, comparing the trace and running, to loading the mission and running (CPU time).
"""

from __future__ import annotations

import os
import random
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

from benchmarks.measuring import CpuWatch, arguments, figure, ratios, spread, table
from bt_mission.base.dds.middleware import prepare_middleware

MISSIONS = ["explore", "patrol", "square", "sweep", "explore_random", "explore_frontiers"]
RUNS_EVERY = 10
"""Forks between two runs without a comparison."""


def run_once(mission: str, folder: Path, recording: Path | None = None) -> str:
    """Run a shipped mission; give the hash of its trace."""
    from bt_mission.base.files import find  # noqa: PLC0415 - after the middleware is prepared
    from bt_mission.recording.writer import RunRecorder  # noqa: PLC0415
    from bt_mission.sessions.load import load  # noqa: PLC0415
    from bt_mission.sessions.stage import Stage  # noqa: PLC0415

    with Stage(load(find("missions", mission)), image_folder=folder, say=lambda _: None) as stage:
        recorder = None if recording is None else RunRecorder(stage, recording)
        while not stage.is_done:
            stage.step()
        if recorder is not None:
            recorder.finish(stage.report(1.0).as_dict())
        return stage.trace.sha256


def fork_once(recording: Path, draw: Callable[[int], int]) -> str:
    """Fork a recording at a drawn control step; give the difference, or nothing."""
    from bt_mission.base.errors import BtMissionError  # noqa: PLC0415 - as above
    from bt_mission.commands.fork.change import ForkChange  # noqa: PLC0415
    from bt_mission.commands.fork.source import read_source  # noqa: PLC0415
    from bt_mission.commands.fork.stage import forked_stage  # noqa: PLC0415

    source = read_source(recording)
    step_ns = source.steps_ns[draw(len(source.steps_ns))]
    try:
        with forked_stage(source, ForkChange(), step_ns) as (stage, finish):
            while not stage.is_done:
                stage.step()
            result = finish(stage.reports(1.0))
    except BtMissionError as error:
        return str(error)
    return "" if result.difference is None else str(result.difference)


def timed(work: Callable[[], str]) -> tuple[float, str]:
    """Do it; give the CPU time, s, and what it gave."""
    watch = CpuWatch()
    result = work()
    return watch.elapsed_s, result


def main() -> None:
    """Fork, and print the figures."""
    options = arguments(
        __doc__, count=(60, "forks of all missions together"), seed=0, missions=MISSIONS
    )
    prepare_middleware()
    names = options.missions
    draws = random.Random(options.seed)
    differences: list[str] = []
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        os.chdir(folder)
        for number, mission in enumerate(names):
            recording = folder / f"{mission}.mcap"
            run_once(mission, folder, recording)
            count = options.count // len(names) + (number < options.count % len(names))
            runs: list[float] = []
            forks: list[float] = []
            different: list[str] = []
            for turn in range(count):
                if turn % RUNS_EVERY == 0:
                    runs.append(timed(partial(run_once, mission, folder))[0])
                seconds, difference = timed(partial(fork_once, recording, draws.randrange))
                forks.append(seconds)
                different += [f"{mission}: {difference}"] if difference else []
            differences += different
            same = f"{count - len(different)} of {count}"
            to_run = ratios(forks[::RUNS_EVERY], runs)
            figure(f"{mission}: fork to run, CPU", to_run)
            figure(f"{mission}: share that is byte-identical", 1 - len(different) / count)
            rows.append((mission, same, spread(runs, "s"), spread(forks, "s"), spread(to_run)))
            print(f"{mission}: {same} the same", file=sys.stderr, flush=True)
    table(("mission", "byte-identical", "run, CPU", "fork, CPU", "fork to run"), rows)
    if differences:
        print("\n".join(differences[:5]))
        sys.exit(1)


if __name__ == "__main__":
    main()
