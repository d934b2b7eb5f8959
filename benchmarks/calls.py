"""The number of calls of a control step, by Python's profiler: without the noise of a machine.

It is the difference of two runs of explore_fixed, so that the set-up does not count. Compiled
functions count, too; a function belongs to its package.
"""

from __future__ import annotations

import cProfile
import gc
import pstats
import tempfile
from collections import Counter
from pathlib import Path

from measuring import arguments, figure, table

from bt_mission.sessions.drive import drive
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.views.terminal.log_lines import LogLineView

STEPS_PER_S = 20
OURS = ("bt_mission", "action_servers", "sim")

Function = tuple[str, int, str]
"""File, line, name."""


def calls_in(duration_s: int) -> Counter[Function]:
    """Return how often each function was called in a run of some virtual seconds."""
    mission = load(Path("missions/explore_fixed.yaml"), {"duration": duration_s})
    profiler = cProfile.Profile()
    with (
        tempfile.TemporaryDirectory() as folder,
        Stage(mission, image_folder=Path(folder), say=lambda _: None) as stage,
    ):
        gc.disable()  # finalizers would come at other steps
        profiler.enable()
        drive(stage, [LogLineView()])
        profiler.disable()
        gc.enable()
    stats = pstats.Stats(profiler).stats  # type: ignore[attr-defined]
    return Counter({function: calls for function, (_, calls, *_) in stats.items()})


def package_of(function: Function) -> str:
    """Return the package of a function: two names of ours, one of others."""
    file, _, name = function
    if file == "~":
        return "compiled"
    parts = Path(file).with_suffix("").parts
    for package in OURS:
        if package in parts and "site-packages" not in parts:
            at = len(parts) - 1 - parts[::-1].index(package)
            return ".".join(parts[at : at + 2])
    if "site-packages" in parts:
        return parts[parts.index("site-packages") + 1]
    return "standard library" if file.startswith("/") else name


def main() -> None:
    """Measure, and print the calls of each package."""
    options = arguments(
        __doc__,
        functions=(0, "show the N most called, too"),
        seconds=([20, 80], "how long the two runs are"),
    )
    short_s, long_s = options.seconds
    calls_in(short_s)  # what is made once for a process
    longer, shorter = calls_in(long_s), calls_in(short_s)
    steps = (long_s - short_s) * STEPS_PER_S
    calls = {name: (count - shorter[name]) / steps for name, count in longer.items()}
    total = sum(calls.values())
    python = sum(count for (file, *_), count in calls.items() if file != "~")
    packages = Counter[str]()
    for function, count in calls.items():
        packages[package_of(function)] += count
    table(("package", "calls a step"), [(k, f"{v:.1f}") for k, v in packages.most_common(30)])
    if options.functions:
        most = sorted(calls.items(), key=lambda item: -item[1])[: options.functions]
        rows = [
            (f"{package_of(f)}", f"{Path(f[0]).name}:{f[1]} {f[2]}", f"{count:.1f}")
            for f, count in most
        ]
        table(("package", "function", "calls a step"), rows)
    print(f"{total:.0f} calls a control step, {python:.0f} of them of Python functions")
    figure("calls a control step", total)
    figure("calls a control step of Python functions", python)


if __name__ == "__main__":
    main()
