"""The common part of the benchmarks: a watch, rounds in turns, medians with their spread, tables.

And the way to pass their figures to `python -m benchmarks`: :func:`figure`.
"""

from __future__ import annotations

import gc
import importlib.util
import json
import os
import statistics
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

NOT_SOUND = 3
"""Exit code of a benchmark that ran and has findings. Findings that depend on the wall clock are
possible on a busy machine; a smoke reports them without failing.
"""

FIGURES_FILE = "BENCHMARK_FIGURES"
"""Environment variable with the file of the figures, a line of JSON each."""


class CpuWatch:
    """CPU time of this thread since the watch was made, in seconds.

    The time of other processes does not count, apart from effects on shared caches.
    """

    def __init__(self) -> None:
        self._start = time.thread_time()

    @property
    def elapsed_s(self) -> float:
        """Seconds so far."""
        return time.thread_time() - self._start


def process_usage(pid: int) -> tuple[float, int]:
    """Return the processor time of a process and its threads, s, and its memory now, bytes."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    ticks = int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK"), int(fields[21]) * os.sysconf("SC_PAGE_SIZE")


Work = Callable[[], float]
"""Does something once, and returns the seconds that count."""


def in_turns(rounds: int, *works: Work) -> list[list[float]]:
    """Return the seconds of each work, round by round, in turns: all have the same noise."""
    times: list[list[float]] = [[] for _ in works]
    for _ in range(rounds):
        for work, seconds in zip(works, times, strict=True):
            gc.collect()
            seconds.append(work())
    return times


def ratios(ours: Sequence[float], theirs: Sequence[float]) -> list[float]:
    """Ours to theirs, round by round."""
    return [own / other for own, other in zip(ours, theirs, strict=True)]


def spread(values: Iterable[float], digits: int = 0, unit: str = "") -> str:
    """Return median, minimum and maximum: ``34 ms (33 to 38)``."""
    ordered = sorted(values)
    median, least, most = (
        f"{value:.{digits}f}" for value in (statistics.median(ordered), ordered[0], ordered[-1])
    )
    return f"{median}{unit and ' ' + unit} ({least} to {most})"


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Print a table in Markdown, each row as soon as it is available."""
    print("| " + " | ".join(head) + " |")
    print("|" + "---|" * len(head))
    for row in rows:
        print("| " + " | ".join(map(str, row)) + " |", flush=True)
    print()


def figure(name: str, values: float | Iterable[float], unit: str = "") -> None:
    """Give a figure to `python -m benchmarks`; nothing happens where a script is started by itself.

    Args:
        name: As `benchmarks/harness/catalogue.py` declares it.
        values: One of each round.
        unit: Of the values; empty for ratios and counts.
    """
    path = os.environ.get(FIGURES_FILE)
    if not path:
        return
    numbers = (
        [float(values)] if isinstance(values, (int, float)) else [float(value) for value in values]
    )
    line = {"figure": name, "unit": unit, "values": numbers, "code": measured_code()}
    with Path(path).open("a", encoding="utf-8") as file:
        file.write(json.dumps(line) + "\n")


def measured_code() -> str:
    """Return the folder of the `bt_mission` that this process imports and measures."""
    spec = importlib.util.find_spec("bt_mission")
    return str(Path(spec.origin).resolve().parent) if spec and spec.origin else ""
