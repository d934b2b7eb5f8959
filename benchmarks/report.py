"""What a recording costs to read: generating its page, and going to any instant of it.

Runs `patrol.yaml` for so many rounds that it takes ten minutes of virtual time, recorded. Processor
time is measured, because the wall clock shows what else the machine does.
Run it as: python benchmarks/report.py [--rounds N] [--seeks N] [--mission FILE]
"""

from __future__ import annotations

import random
import tempfile
import time
from pathlib import Path

from measuring import arguments, figures, times

from bt_mission.recording.replay.player import TimelineSeeker
from bt_mission.recording.replay.timeline import read_timeline
from bt_mission.recording.writer import RunRecorder
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.views.web.report.page import page_of, robot_runs

PATROL = Path("missions/patrol.yaml")
FURTHER_ROUNDS = 6
"""Of the patrol, 90 s each."""


def record(path: Path, file: Path) -> float:
    """Record a mission, the patrol with further rounds. Return the virtual seconds."""
    mission = load(file, set={"further_rounds": FURTHER_ROUNDS} if file == PATROL else {})
    with Stage(mission, image_folder=path.parent, say=lambda _: None) as stage:
        recorder = RunRecorder(stage, path)
        while not stage.is_done:
            stage.step()
        report = stage.report(1.0)
        recorder.finish(report.as_dict())
    return report.virtual_s


def pages(path: Path, rounds: int) -> tuple[list[float], list[float], float]:
    """Read a recording and generate its page; gives the seconds of both, and the page's MB."""
    reading, making, length = [], [], 0
    for _ in range(rounds):
        begin = time.process_time()
        runs = list(robot_runs(path))
        read = time.process_time()
        length = len(page_of(runs).encode())
        reading.append(read - begin)
        making.append(time.process_time() - read)
    return reading, making, length / 1e6


def seeks(path: Path, count: int) -> list[float]:
    """Return the seconds of going to drawn instants, once the recording was played to its end."""
    timeline = read_timeline(path)
    seeker, draw, seconds = TimelineSeeker(timeline), random.Random(1), []
    seeker.seek(timeline.end_ns)
    for _ in range(count):
        time_ns = draw.randint(timeline.start_ns, timeline.end_ns)
        begin = time.process_time()
        seeker.seek(time_ns)
        seconds.append(time.process_time() - begin)
    return seconds


def main() -> None:
    """Measure, and print a table."""
    options = arguments(__doc__, rounds=5, seeks=1000, mission=PATROL)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        virtual_s = record(path, options.mission)
        reading, making, page_mb = pages(path, options.rounds)
        seeking_ms = times(1000, seeks(path, options.seeks))
        size_mb = path.stat().st_size / 1e6
    figures(
        f"{options.mission.name}, {virtual_s:.1f} s virtual, {size_mb:.1f} MB",
        {
            "read a recording, CPU": (reading, "s"),
            "make the page, CPU": (making, "s"),
            "size of the page": (page_mb, "MB"),
            "go to any instant, CPU": (seeking_ms, "ms"),
        },
    )


if __name__ == "__main__":
    main()
