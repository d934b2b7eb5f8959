"""The common part of campaigns: trials by their numbers, and what they have found.

Each trial is one line of JSON in the results, with its `number` and its `findings`; a second run
continues where the first was stopped.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import asdict, is_dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NoReturn

from benchmarks.measuring import NOT_SOUND, figure

Line = dict[str, Any]
AT_ONCE = 200
"""Trials of a process before it is replaced, which bounds its memory."""


def read(path: Path) -> list[Line]:
    """Return the results so far."""
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    return [json.loads(line) for line in text.splitlines()]


def missing(path: Path, count: int) -> list[int]:
    """Return the numbers without a line in the results."""
    done = {line["number"] for line in read(path)}
    return [number for number in range(count) if number not in done]


def write(outcomes: Iterable[Any], path: Path) -> list[Line]:
    """Append outcomes, mappings or dataclasses, as they come; return all results."""
    with path.open("a", encoding="utf-8") as results:
        for outcome in outcomes:
            line = asdict(outcome) if is_dataclass(outcome) else outcome
            results.write(json.dumps(line) + "\n")
            results.flush()
            print(f"{line['number']}:", *line["findings"] or ["no finding"], flush=True)
    return read(path)


def carry_out(
    trial: Callable[[int], Any],
    numbers: Iterable[int],
    path: Path,
    jobs: int,
    initializer: Callable[[], None] | None = None,
) -> list[Line]:
    """Run trials in processes; return all results."""
    with get_context("spawn").Pool(jobs, initializer, maxtasksperchild=AT_ONCE) as pool:
        return write(pool.imap_unordered(trial, numbers), path)


def conclude(lines: list[Line], *texts: str) -> NoReturn:
    """Print the figures of a campaign; end with an exit code of their own if there are findings."""
    findings = [finding for line in lines for finding in line["findings"]]
    figure("findings", len(findings))
    kinds = Counter(finding.partition(":")[0] for finding in findings)
    print(*texts, f"findings: {dict(kinds) or 'none'}", sep="\n")
    raise SystemExit(NOT_SOUND if findings else 0)


def counted(values: Iterable[Any]) -> Line:
    """Return how often each value occurs."""
    return dict(Counter(values))
