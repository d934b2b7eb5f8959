"""What recording costs: time, and bytes.

Each round runs a mission on the stage without a recorder and with one, in one process, one after
another. A run repeats exactly, so each second of its virtual time is compared with itself: the
processor time of the quietest round counts, since everything else that a busy machine does only
adds to it. The trace must be the same, too.
Run it as: python benchmarks/recording.py [MISSION ...] [--rounds N]
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from measuring import figure

from bt_mission.language.mission import Mission
from bt_mission.recording.writer import RunRecorder
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage

MISSIONS = ("missions/explore.yaml", "missions/patrol.yaml")


@dataclass(frozen=True)
class Run:
    """What one run came to; `seconds` is the processor time of each second of virtual time."""

    seconds: list[float]
    virtual_s: float
    trace: str
    messages: int = 0
    bytes: int = 0


def run(mission: Mission, *, records: bool = False) -> Run:
    """Run a mission, recorded or not."""
    with (
        tempfile.TemporaryDirectory() as folder,
        Stage(mission, image_folder=Path(folder), say=lambda _: None) as stage,
    ):
        marks = [time.thread_time()]
        recorder = RunRecorder(stage, Path(folder) / "run.mcap") if records else None
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
        file = recorder.file
        return Run(seconds, report.virtual_s, report.trace_sha256, file.messages, file.bytes)


def quietest(runs: list[Run]) -> float:
    """Return the processor time of a run, each of its seconds from the quietest round."""
    return sum(map(min, zip(*(timed.seconds for timed in runs), strict=True)))


def measure(mission_file: Path, rounds: int) -> None:
    """Measure one mission, and print the results."""
    mission = load(mission_file)
    run(mission, records=True)  # the first run imports and compiles
    bare, recorded = [], []
    for _ in range(rounds):
        bare.append(run(mission))
        recorded.append(run(mission, records=True))
    if len({timed.trace for timed in bare + recorded}) > 1:
        raise SystemExit(f"{mission_file}: recording has changed the run")
    ratios = [sum(b.seconds) / sum(a.seconds) for a, b in zip(bare, recorded, strict=True)]
    first = recorded[0]
    name = mission_file.stem
    figure(f"{name}: CPU with a recording to without", quietest(recorded) / quietest(bare))
    figure(f"{name}: the same of whole runs", ratios)
    per_minute = 60 / first.virtual_s
    print(
        f"{mission_file}: {first.virtual_s:.2f} s virtual, trace {first.trace[:8]}, {rounds} rounds"
    )
    print(
        "  processor time with recording over that without: "
        f"{quietest(recorded) / quietest(bare):.3f}"
    )
    print(
        f"  the same of whole runs: median {statistics.median(ratios):.3f}, "
        f"from {min(ratios):.3f} to {max(ratios):.3f}"
    )
    figure(f"{name}: size of a virtual minute", first.bytes * per_minute / 1e6, "MB")
    print(
        f"  per virtual minute: {first.bytes * per_minute / 1e6:.2f} MB, "
        f"{first.messages * per_minute:.0f} messages"
    )


def main() -> None:
    """Measure each mission."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("missions", nargs="*", type=Path, default=[Path(m) for m in MISSIONS])
    parser.add_argument("--rounds", type=int, default=7)
    options = parser.parse_args()
    for mission_file in options.missions:
        measure(mission_file, options.rounds)


if __name__ == "__main__":
    main()
