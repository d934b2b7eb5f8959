"""What the benchmarks share: a watch, rounds that take turns, medians with their spread, tables."""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable, Iterable, Sequence


class CpuWatch:
    """CPU time of this thread since it was made, in seconds.

    What other processes do on the machine is not in it, apart from the caches that they share.
    """

    def __init__(self) -> None:
        self._start = time.thread_time()

    @property
    def elapsed_s(self) -> float:
        """Seconds so far."""
        return time.thread_time() - self._start


Work = Callable[[], float]
"""Does something once, and gives the seconds that counted."""


def in_turns(rounds: int, *works: Work) -> list[list[float]]:
    """Seconds of each work, round by round: one after another, so that all meet the same noise."""
    found: list[list[float]] = [[] for _ in works]
    for _ in range(rounds):
        for work, seconds in zip(works, found, strict=True):
            gc.collect()
            seconds.append(work())
    return found


def ratios(ours: Sequence[float], theirs: Sequence[float]) -> list[float]:
    """Ours to theirs, round by round."""
    return [one / other for one, other in zip(ours, theirs, strict=True)]


def spread(values: Iterable[float], digits: int = 0, unit: str = "") -> str:
    """The median, the least and the most: ``34 ms (33 to 38)``."""
    ordered = sorted(values)
    median, least, most = (
        f"{value:.{digits}f}" for value in (statistics.median(ordered), ordered[0], ordered[-1])
    )
    return f"{median}{unit and ' ' + unit} ({least} to {most})"


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Print a table in Markdown, a row as soon as it is there."""
    print("| " + " | ".join(head) + " |")
    print("|" + "---|" * len(head))
    for row in rows:
        print("| " + " | ".join(map(str, row)) + " |", flush=True)
    print()
