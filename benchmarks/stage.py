"""The cost of a stage besides its physics: set-up, and memory over hours.

Run it as: python benchmarks/stage.py [--only fresh|memory ...] [--help]
"""

from __future__ import annotations

import os
import tempfile
from argparse import Namespace
from pathlib import Path
from typing import Any

from measuring import arguments, figures, in_turns, process_usage

from bt_mission.base.dds.discovery import isolate
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage

LEAN: dict[str, Any] = {"enable_rosout": False, "start_parameter_services": False}
STEPS = 500
WAITS = "mission: waits\ntree: {wait: 10000000}\n"


def fresh(options: Namespace) -> None:
    """Measure a stage that is made, stepped once and closed."""
    mission = load("mission: m\nworld: empty_arena\ntree: {turn: {angle: 9}, timeout: 9}\n")

    def work() -> float:
        watch = Stopwatch()
        with (
            tempfile.TemporaryDirectory() as folder,
            Stage(mission, image_folder=Path(folder)) as s,
        ):
            s.step()
        return watch.elapsed_s * 1000

    work()
    (wall_ms,) = in_turns(3 * options.rounds, work)
    figures("made, stepped, closed; after the first", {"a fresh stage": (wall_ms, "ms")})


def resident_mib() -> float:
    """Return the memory of this process now, MiB."""
    return process_usage(os.getpid())[1] / 2**20


def memory(options: Namespace) -> None:
    """Measure the memory of a stage, and its growth over some hours of virtual time."""
    before = resident_mib()
    mission = load(WAITS)
    with (
        tempfile.TemporaryDirectory() as folder,
        Stage(mission, image_folder=Path(folder)) as stage,
    ):
        settled_ns = stage.now_ns + round(options.settle * 1e9)
        end_ns = settled_ns + round(options.hours * 3600e9)
        while stage.now_ns < settled_ns:
            stage.step()
        at_first = resident_mib()
        while stage.now_ns < end_ns:
            stage.step()
        grown = resident_mib() - at_first
    figures(
        f"memory, and its growth over {options.hours:g} virtual hours",
        {
            "memory of a stage": (at_first - before, "MiB"),
            "growth of memory a virtual hour": (grown / options.hours, "MiB"),
        },
    )


def main() -> None:
    """Measure all parts, or some."""
    options = arguments(
        __doc__,
        only={"fresh": fresh, "memory": memory},
        rounds=7,
        hours=(2.0, "virtual, for the memory"),
        settle=(300.0, "virtual seconds before them"),
    )
    isolate(visible=False)
    for part in options.only:
        part(options)


if __name__ == "__main__":
    main()
