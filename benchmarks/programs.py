"""What a sleep of a program costs, against a coroutine that awaits the same time.

Both have a lock-step executor of their own, without a world.
Run it as: python benchmarks/programs.py [--rounds N]
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import rclpy
from measuring import CpuWatch, arguments, figures, in_turns, ratios
from rclpy.context import Context
from rclpy.task import Future

from bt_mission.base.dds.discovery import isolate
from bt_mission.programs import ProgramHost
from bt_mission.programs.mains import MainProgram
from bt_mission.ros.virtual_time import VirtualTimeExecutor

SLEEPS = 1000
"""Sleeps of one measurement."""

PERIOD_NS = 10_000_000
PROGRAM = "import time, rclpy\nrclpy.init()\nwhile True:\n    time.sleep(0.01)\n"


def awaiting(clock: VirtualTimeExecutor) -> None:
    """Run a coroutine that awaits one time after another."""

    async def go_on() -> None:
        while True:
            over: Future = Future()
            clock.call_at(clock.now_ns + PERIOD_NS, partial(over.set_result, None))
            await over

    clock.create_task(go_on)
    clock.run_until_quiet()


def sleeping(clock: VirtualTimeExecutor, folder: Path) -> ProgramHost:
    """Run a program that sleeps."""
    file = folder / "sleeps.py"
    file.write_text(PROGRAM, encoding="utf-8")
    host = ProgramHost(clock)
    host.run_main(MainProgram(host, "0", file, (), print), lambda: None)
    clock.run_until_quiet()
    return host


def steps(clock: VirtualTimeExecutor) -> Callable[[], float]:
    """Return what measures a step, us."""

    def measure() -> float:
        watch = CpuWatch()
        for _ in range(SLEEPS):
            clock.step()
        us_a_step: float = watch.elapsed_s / SLEEPS * 1e6
        return us_a_step

    return measure


def main() -> None:
    """Measure both in turns."""
    options = arguments(__doc__, rounds=9)
    isolate(visible=False)
    context = Context()
    rclpy.init(context=context)
    mine, theirs = (VirtualTimeExecutor(context=context) for _ in range(2))
    awaiting(theirs)
    with TemporaryDirectory() as folder:
        host = sleeping(mine, Path(folder))
        slept, awaited = in_turns(options.rounds, steps(mine), steps(theirs))
        host.close()
    figures(
        "a wait",
        {
            "a sleep of a program": (slept, "us"),
            "an awaited time": (awaited, "us"),
            "a sleep above an awaited time": (
                [own - other for own, other in zip(slept, awaited, strict=True)],
                "us",
            ),
            "a sleep to an awaited time": (ratios(slept, awaited), ""),
        },
    )
    context.shutdown()


if __name__ == "__main__":
    main()
