"""What replaying costs: reading a recording, and going to any instant of it.

Records ten minutes of patrol as `benchmarks/report.py` does. Processor time is told, because the
wall clock shows what else the machine does.
Run it as: python benchmarks/replaying.py [--seeks N]
"""

from __future__ import annotations

import argparse
import random
import statistics
import tempfile
import time
from pathlib import Path

from measuring import figure
from report import PATROL, record

from bt_mission.recording.replay.player import TimelineSeeker
from bt_mission.recording.replay.timeline import read_timeline


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeks", type=int, default=1000)
    parser.add_argument("--mission", type=Path, help="instead of the patrol")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        virtual_s = record(path, Path(folder), options.mission)
        begin = time.process_time()
        timeline = read_timeline(path)
        reading = time.process_time() - begin
        size = path.stat().st_size
    seeker = TimelineSeeker(timeline)
    begin = time.process_time()
    seeker.seek(timeline.end_ns)
    playing = time.process_time() - begin
    seeks = []
    draw = random.Random(1)
    for _ in range(options.seeks):
        time_ns = draw.randint(timeline.start_ns, timeline.end_ns)
        begin = time.process_time()
        seeker.seek(time_ns)
        seeks.append(time.process_time() - begin)
    seeks.sort()
    figure("read a recording, CPU", reading, "s")
    figure("go to any instant, CPU", (1000 * one for one in seeks), "ms")
    name = (options.mission or Path(PATROL)).name
    print(f"{name}, {virtual_s:.1f} s virtual, recording of {size / 1e6:.1f} MB")
    print(f"  read it: {reading:.2f} s; {len(timeline.frames)} messages are of use")
    print(f"  from the start to the end for the first time: {playing:.2f} s")
    print(
        f"  to any instant: median {statistics.median(seeks) * 1e3:.1f} ms, "
        f"99 of 100 below {seeks[len(seeks) * 99 // 100] * 1e3:.1f} ms"
    )


if __name__ == "__main__":
    main()
