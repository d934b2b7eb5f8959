"""The common part of the benchmarks: command lines, a watch, rounds in turns, medians, tables.

And the way to pass their figures to `python -m benchmarks`: :func:`figure`.
"""

from __future__ import annotations

import argparse
import gc
import importlib.util
import json
import os
import statistics
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

NOT_SOUND = 3
"""Exit code of a benchmark that ran and has findings. Findings that depend on the wall clock are
possible on a busy machine; a smoke reports them without failing.
"""

FIGURES_FILE = "BENCHMARK_FIGURES"
"""Environment variable with the file of the figures, a line of JSON each."""


def arguments(about: str | None, **options: Any) -> argparse.Namespace:
    """Read the command line of a script.

    Args:
        about: The docstring of the script; `--help` prints it.
        options: Of each option the default, or a pair of the default and its help text. A list
            takes several values. A mapping is a choice of its keys: the result is the list of the
            chosen values, or of all.
    """
    parser = argparse.ArgumentParser(
        description=about, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    choices: dict[str, Mapping[str, Any]] = {}
    for name, option in options.items():
        default, text = option if isinstance(option, tuple) else (option, "")
        flag, text = f"--{name.replace('_', '-')}", f"{text} (default: {default})".strip()
        if isinstance(default, Mapping):
            choices[name] = default
            text = "run only these parts"
            parser.add_argument(flag, nargs="+", choices=default, default=[*default], help=text)
        elif isinstance(default, bool):
            parser.add_argument(flag, action="store_true", help=text)
        elif isinstance(default, list):
            kind = type(default[0])
            parser.add_argument(flag, nargs="*", type=kind, default=default, help=text)
        else:
            kind = int if default is None else type(default)
            parser.add_argument(flag, type=kind, default=default, help=text)
    read = parser.parse_args()
    for name, values in choices.items():
        setattr(read, name, [values[key] for key in getattr(read, name)])
    return read


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


def times(factor: float, values: Iterable[float]) -> list[float]:
    """Return values in another unit: ``times(1000, seconds)`` are milliseconds."""
    return [factor * value for value in values]


def spread(values: Sequence[float], unit: str = "") -> str:
    """Return median, minimum and maximum: ``34.0 ms (33.0 to 38.0)``."""
    if not values:
        return ""
    median, least, most = map(_digits, (statistics.median(values), min(values), max(values)))
    name = f"{median} {unit}" if unit else median
    return name if least == most else f"{name} ({least} to {most})"


def _digits(value: float) -> str:
    """Return three significant digits, without an exponent."""
    if value == 0:
        return "0"
    if abs(value) >= 100:
        return f"{value:.0f}"
    return f"{value:.{2 if abs(value) >= 1 else 3}f}"


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Print a table in Markdown, each row as soon as it is available."""
    print("| " + " | ".join(head) + " |")
    print("|" + "---|" * len(head))
    for row in rows:
        print("| " + " | ".join(map(str, row)) + " |", flush=True)
    print()


Values = float | Iterable[float]
"""Of a figure: one, or one of each round."""


def figure(name: str, values: Values, unit: str = "") -> list[float]:
    """Give a figure to `python -m benchmarks`, if that has started the script; return its values.

    Args:
        name: As `benchmarks/harness/catalogue.py` declares it.
        values: One of each round.
        unit: Of the values; empty for ratios and counts.
    """
    numbers = list(map(float, [values] if isinstance(values, (int, float)) else values))
    if path := os.environ.get(FIGURES_FILE):
        line = {"figure": name, "unit": unit, "values": numbers, "code": measured_code()}
        with Path(path).open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
    return numbers


def figures(title: str, named: Mapping[str, tuple[Values, str]]) -> None:
    """Give figures, each with its unit, and print them as a table."""
    rows = [
        (name, spread(figure(name, values, unit), unit)) for name, (values, unit) in named.items()
    ]
    table((title, "median (least to most)"), rows)


def measured_code() -> str:
    """Return the folder of the `bt_mission` that this process imports and measures."""
    spec = importlib.util.find_spec("bt_mission")
    return str(Path(spec.origin).resolve().parent) if spec and spec.origin else ""
