"""What requirements and recording cost a run: time, and bytes.

Each round runs a mission on the stage in every way, in one process, one after another: bare,
recorded, with twenty requirements, with one of the clearance, and with both. A run repeats exactly,
so each second of its virtual time is compared with itself: the processor time of the quietest round
counts, since everything else that a busy machine does only adds to it. Recording must not change
the trace.
Run it as: python benchmarks/costs.py [--only recording|requirements] [--missions FILE ...]
"""

from __future__ import annotations

import tempfile
import time
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

from measuring import arguments, figure, figures, ratios, spread, table

from bt_mission.language.mission import Mission, Requirement
from bt_mission.recording.writer import RunRecorder
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.views.web.report.page import page_of, robot_runs

MISSIONS = [Path("missions/explore.yaml"), Path("missions/patrol.yaml")]
SOME = (
    "never collisions > 0",
    "always speed < 0.3",
    'whenever speed > 0.1: previously running("0")',
    "eventually within 600 s: distance > 1",
    'whenever age("scan") > 0.5: speed < 0.01 within 0.6 s',
)
CLEARANCE = "always clearance > 0.01"
REQUIREMENTS = {
    "twenty": SOME * 4,
    "clearance alone": (CLEARANCE,),
    "twenty and clearance": (*SOME * 4, CLEARANCE),
}
BARE, RECORDED = "without", "recorded"


@dataclass(frozen=True)
class Run:
    """The outcome of a run; `seconds` is the processor time of each second of virtual time.

    Of a recorded one also the processor time of reading it, and of making its page.
    """

    seconds: list[float]
    virtual_s: float
    trace: str
    messages: int = 0
    bytes: int = 0
    reading_s: float = 0.0
    page_s: float = 0.0


def run(mission: Mission, way: str) -> Run:
    """Run a mission in a way."""
    texts = REQUIREMENTS.get(way, ())
    formulas = (Requirement(f"{n}", text) for n, text in enumerate(texts))
    with (
        tempfile.TemporaryDirectory() as folder,
        Stage(
            replace(mission, requirements=tuple(formulas)),
            image_folder=Path(folder),
            say=lambda _: None,
        ) as stage,
    ):
        marks = [time.thread_time()]
        recorder = RunRecorder(stage, Path(folder) / "run.mcap") if way == RECORDED else None
        next_ns = stage.start_ns
        while not stage.is_done:
            stage.step()
            if stage.now_ns >= next_ns:
                next_ns += 1_000_000_000
                marks.append(time.thread_time())
        report = stage.report(1.0)
        if recorder is not None:
            recorder.finish(report.as_dict())
        marks.append(time.thread_time())
        seconds = [after - before for before, after in pairwise(marks)]
        if recorder is None:
            return Run(seconds, report.virtual_s, report.trace_sha256)
        begin = time.thread_time()
        recordings = list(robot_runs(Path(folder) / "run.mcap"))
        read = time.thread_time()
        page_of(recordings)
        reading_s, page_s = read - begin, time.thread_time() - read
        file = recorder.file
        size = (file.messages, file.bytes)
        return Run(seconds, report.virtual_s, report.trace_sha256, *size, reading_s, page_s)


def quietest(runs: list[Run]) -> float:
    """Return the processor time of a run, each of its seconds from the quietest round."""
    return sum(map(min, zip(*(timed.seconds for timed in runs), strict=True)))


def measured(mission: Mission, ways: list[str], rounds: int) -> dict[str, list[Run]]:
    """Run a mission in turns without anything, and in each way."""
    runs: dict[str, list[Run]] = {way: [] for way in (BARE, *ways)}
    run(mission, ways[-1])  # the first run imports and compiles
    for _ in range(rounds):
        for way, timed in runs.items():
            timed.append(run(mission, way))
    return runs


def compare(file: Path, runs: dict[str, list[Run]]) -> dict[str, tuple[float, list[float]]]:
    """Print and return the cost of each way to a bare run: of the quietest, and of the rounds."""
    bare = runs[BARE]
    totals = {way: [sum(timed.seconds) for timed in some] for way, some in runs.items()}
    costs = {
        way: (quietest(runs[way]) / quietest(bare), ratios(totals[way], totals[BARE]))
        for way in runs
        if way != BARE
    }
    rows = [(way, f"{quiet:.3f}", spread(rounds)) for way, (quiet, rounds) in costs.items()]
    head = f"{file}: {bare[0].virtual_s:.2f} s virtual, CPU {quietest(bare):.2f} s without"
    table((head, "quietest", "rounds"), rows)
    return costs


def requirements(file: Path, rounds: int) -> None:
    """Measure what requirements cost a mission."""
    costs = compare(file, measured(load(file), [*REQUIREMENTS], rounds))
    for way, (_, of_rounds) in costs.items():
        figure(f"{file.stem}: {way} to without", of_rounds)


def recording(file: Path, rounds: int) -> None:
    """Measure what recording costs a mission, and the size of the recording."""
    runs = measured(load(file), [RECORDED], rounds)
    if len({timed.trace for some in runs.values() for timed in some}) > 1:
        raise SystemExit(f"{file}: recording has changed the run")
    quiet, of_rounds = compare(file, runs)[RECORDED]
    figure(f"{file.stem}: CPU with a recording to without", quiet)
    figure(f"{file.stem}: the same of whole runs", of_rounds)
    recorded = runs[RECORDED][0]
    per_minute = 60 / recorded.virtual_s
    figure(f"{file.stem}: size of a virtual minute", recorded.bytes * per_minute / 1e6, "MB")
    figures(
        "of the recording",
        {
            f"{file.stem}: read a virtual minute": (
                [timed.reading_s * per_minute for timed in runs[RECORDED]],
                "s",
            ),
            f"{file.stem}: make the page of a virtual minute": (
                [timed.page_s * per_minute for timed in runs[RECORDED]],
                "s",
            ),
        },
    )
    print(
        f"a virtual minute: {recorded.bytes * per_minute / 1e6:.2f} MB, "
        f"{recorded.messages * per_minute:.0f} messages; trace {recorded.trace[:8]}\n"
    )


def main() -> None:
    """Measure each mission."""
    parts = {"recording": recording, "requirements": requirements}
    options = arguments(__doc__, only=parts, missions=MISSIONS, rounds=7)
    for part in options.only:
        for file in options.missions:
            part(file, options.rounds)


if __name__ == "__main__":
    main()
