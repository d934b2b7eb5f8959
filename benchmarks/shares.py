"""Where the time of a step goes: samples of a run on the stage, by the part that is at work.

A timer interrupts the run about every millisecond, at times drawn at random so that it keeps no
step with the control steps, and looks at the stack: the innermost function of ours decides what the
sample counts for. A library counts for whoever called it, a message that is serialized for the
sender. The share is turned into time with the processor time of a step in runs without the timer.

What it gets wrong: Python looks for signals between its own instructions, so a sample within a long
call into C (MuJoCo, DDS) counts when it returns, still for the function that called it; a Python
function that is shorter than some instructions may lose samples to its caller. Compiled functions
of ours have no frame: their time counts for the Python function that called them. With N samples, a
share p has a standard error of sqrt(p (1 - p) / N): 0.4 % of a share of 15 % with 7,000. The timer
runs on the wall: what the machine does meanwhile hits all parts alike.

Run it as: python benchmarks/shares.py [MISSION] [--rounds N] [--json FILE]; tools/draw_shares.py
draws two of these files beside each other.
"""

from __future__ import annotations

import argparse
import json
import random
import signal
import tempfile
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import CodeType, FrameType

from measuring import CpuWatch, figure, measured_code, table

from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage

INTERVAL_S = 0.001
"""Between two samples, on average."""
REST, CALLER = "rest", ""

ROOMS: tuple[tuple[str, tuple[str, ...]], ...] = (
    (CALLER, ("bt_mission/ros/observable_publisher",)),
    ("feedback", ("action_servers/*feedback", "bt_mission/goals/*feedback")),
    ("trace", ("bt_mission/executive/trace",)),
    ("physics", ("sim/physics/", "sim/world/")),
    ("lidar", ("sim/sensors/lidar", "sim/robot/robot.py*scan")),
    ("camera", ("sim/sensors/ca", "sim/ros/pictures")),
    ("odometry and other sensors", ("sim/sensors/", "sim/robot/")),
    ("publishing by the simulation", ("sim/",)),
    ("checks of what is ready", ("bt_mission/executors/entities",)),
    ("tasks", ("bt_mission/executors/coroutines",)),
    ("callbacks served", ("bt_mission/executors/callbacks", "bt_mission/executors/taps")),
    ("executor", ("bt_mission/virtual_time/", "bt_mission/executors/")),
    ("mapping", ("action_servers/mapping/", "action_servers/navigation/")),
    ("sensors read, commands sent", ("action_servers/robot_io/",)),
    ("pilot and maneuvers", ("action_servers/",)),
    ("status topics", ("bt_mission/ros/status", "bt_mission/ros/mission_details")),
    ("recording", ("bt_mission/recording/",)),
    ("requirements", ("bt_mission/requirements/", "bt_mission/ros/requirement")),
    (
        "executive's tick",
        (
            "bt_mission/executive/",
            "bt_mission/behaviours/",
            "bt_mission/goals/",
            "bt_mission/language/",
            "bt_mission/ros/",
        ),
    ),
    (REST, ("bt_mission/sessions/",)),
)
"""Parts with the beginnings of their files; behind a star, what the function's name contains. The
first that fits counts. What is in no part, such as `bt_mission/core`, counts for its caller."""


def room_of(file: str, function: str) -> str | None:
    """The part that a function belongs to; None where its caller decides.

    Args:
        file: Relative to the sources, such as ``sim/physics/physics.py``.
        function: With its class.
    """
    for room, patterns in ROOMS:
        for pattern in patterns:
            begin, _, contained = pattern.partition("*")
            if file.startswith(begin) and contained in function:
                return room or None
    return None


@dataclass
class Samples:
    """How often each part was found at work.

    Args:
        root: The folder of the sources.
    """

    root: Path
    rooms: Counter[str] = field(default_factory=Counter)
    functions: Counter[str] = field(default_factory=Counter)
    _known: dict[tuple[str, str], str | None] = field(default_factory=dict)

    def take(self, frame: FrameType | None) -> None:
        """Count a sample for the innermost function that belongs to a part."""
        while frame is not None:
            code = frame.f_code
            place = (code.co_filename, code.co_qualname)  # equal code need not be the same
            if place not in self._known:
                self._known[place] = self._room(code)
            room = self._known[place]
            if room is not None:
                self.rooms[room] += 1
                self.functions[f"{Path(code.co_filename).stem}.{code.co_qualname}"] += 1
                return
            frame = frame.f_back
        self.rooms[REST] += 1

    def _room(self, code: CodeType) -> str | None:
        file = Path(code.co_filename)
        if not file.is_relative_to(self.root):
            return None
        return room_of(file.relative_to(self.root).as_posix(), code.co_qualname)


@contextmanager
def sampling(samples: Samples, draws: random.Random) -> Iterator[None]:
    """Take samples of this thread while this is open."""
    is_open = True

    def arm() -> None:
        signal.setitimer(signal.ITIMER_REAL, INTERVAL_S * draws.uniform(0.5, 1.5))

    def on_alarm(_: int, frame: FrameType | None) -> None:
        # The last alarm may be handled after the timer was stopped.
        if is_open:
            samples.take(frame)
            arm()

    before = signal.signal(signal.SIGALRM, on_alarm)
    arm()
    try:
        yield
    finally:
        is_open = False
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def run(mission_file: Path, samples: Samples | None, draws: random.Random) -> tuple[float, int]:
    """Run a mission, with samples or without; gives processor time, s, and steps."""
    mission = load(mission_file)
    with (
        tempfile.TemporaryDirectory() as folder,
        Stage(mission, image_folder=Path(folder), say=lambda _: None) as stage,
    ):
        steps, watch = 0, CpuWatch()
        if samples is None:
            while not stage.is_done:
                stage.step()
                steps += 1
            return watch.elapsed_s, steps
        with sampling(samples, draws):
            while not stage.is_done:
                stage.step()
                steps += 1
        return watch.elapsed_s, steps


def main() -> None:
    """Sample, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    default = Path(__file__).with_name("explore_no_camera.yaml")
    parser.add_argument("mission", nargs="?", type=Path, default=default)
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--json", type=Path, metavar="FILE", help="write it for the chart")
    options = parser.parse_args()
    samples, draws = Samples(Path(measured_code()).parent), random.Random(1)
    run(options.mission, None, draws)  # the first run imports and compiles
    bare_us = []
    for _ in range(options.rounds):
        seconds, steps = run(options.mission, None, draws)
        bare_us.append(1e6 * seconds / steps)
        run(options.mission, samples, draws)
    tell(options.mission, samples, min(bare_us), options.json)


def tell(mission: Path, samples: Samples, step_us: float, file: Path | None) -> None:
    """Print the table, and write the file."""
    total = samples.rooms.total()
    shares = {room: samples.rooms[room] / total for room, _ in ROOMS if room != CALLER}
    figure("a step, CPU", step_us, "us")
    for room, share in shares.items():
        figure(f"{room}: CPU a step", share * step_us, "us")
    print(f"{mission.name}: {step_us:.0f} us of processor time a step, {total} samples\n")
    rows = sorted(shares.items(), key=lambda one: -one[1])
    cells = ((room, f"{100 * share:.1f} %", f"{share * step_us:.0f}") for room, share in rows)
    table(("part", "share", "us a step"), cells)
    often = samples.functions.most_common(12)
    table(("function", "share"), ((name, f"{100 * n / total:.1f} %") for name, n in often))
    if file is not None:
        found = {
            "mission": mission.name,
            "samples": total,
            "step_us": step_us,
            "rooms": {room: share * step_us for room, share in shares.items()},
        }
        file.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
