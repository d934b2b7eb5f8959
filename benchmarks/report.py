"""What a report costs: reading a recording, generating the page, and the size of the page.

Runs `patrol.yaml` for so many rounds that it takes ten minutes of virtual time, recorded, and then
makes its page. Processor time is told, because the wall clock shows what else the machine does.
Run it as: python benchmarks/report.py [--rounds N]
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from pathlib import Path

from measuring import figure

from bt_mission.recording.writer import RunRecorder
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.views.web.report.page import page_of, robot_runs

PATROL = "missions/patrol.yaml"
FURTHER_ROUNDS = 6
"""Of the patrol, 90 s each."""


def record(path: Path, images: Path, file: Path | None = None) -> float:
    """Record a mission, without one ten minutes of patrol; gives the virtual seconds."""
    if file is None:
        mission = load(Path(PATROL), set={"further_rounds": FURTHER_ROUNDS})
    else:
        mission = load(file)
    with Stage(mission, image_folder=images, say=lambda _: None) as stage:
        recorder = RunRecorder(stage, path)
        while not stage.is_done:
            stage.step()
        report = stage.report(1.0)
        recorder.finish(report.as_dict())
    return report.virtual_s


def main() -> None:
    """Measure, and print medians."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--mission", type=Path, help="instead of the patrol")
    options = parser.parse_args()
    reading, making, length = [], [], 0
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        virtual_s = record(path, Path(folder), options.mission)
        for _ in range(options.rounds):
            begin = time.process_time()
            runs = list(robot_runs(path))
            read = time.process_time()
            length = len(page_of(runs).encode())
            reading.append(read - begin)
            making.append(time.process_time() - read)
        size = path.stat().st_size
    figure("read a recording, CPU", reading, "s")
    figure("make the page, CPU", making, "s")
    figure("size of the page", length / 1e6, "MB")
    name = (options.mission or Path(PATROL)).name
    print(f"{name}, {virtual_s:.1f} s virtual, recording of {size / 1e6:.1f} MB")
    print(f"  read it: median {statistics.median(reading):.2f} s")
    print(f"  make the page: median {statistics.median(making):.2f} s")
    print(f"  the page: {length / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
