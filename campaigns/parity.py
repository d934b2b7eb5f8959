"""Programs under rclpy in real time, and on the stage: do they do the same, at the same times?

Run it as: python campaigns/parity.py [--cases WORD] [--jobs 1] [--results parity.jsonl]

Each case runs some of the programs in ``programs/`` twice: as processes, and on the virtual clock
of a stage. Their lines, the exit codes and the times of the lines are compared. The lines of the
last program, the main one, align the clocks. When that has ended, the others get SIGINT. Times
may differ by the period of what a case waits for, and by what the start of a process and its
discovery take. A case is the same if one of three runs in real time is.
"""

from __future__ import annotations

import re
import tempfile
from pathlib import Path
from statistics import median

from parity_cases import CASES, Case
from parity_runs import Lines, Ran, in_real_time, on_the_stage
from trials import Line, carry_out, conclude, missing

from benchmarks.measuring import arguments, figure
from bt_mission.scenarios.runner import silence_logs

RUNS = 3
"""In real time, where what comes within milliseconds has another order from run to run."""
SLACK_S = 0.4
"""Of real time: processes share processors."""

_LOG = re.compile(
    r"(\x1b\[\d+m)?\[(INFO|WARN|ERROR|FATAL|DEBUG)\] \[|Failed to publish log message|"
    r"The following exception was never retrieved"
)
"""What the logs of nodes print, and futures that nobody asks."""
_PLACE = re.compile(r", at \S+:\d+$")
"""The place in the sources of rcl."""


def shown(printed: Lines) -> Lines:
    """Return the lines of a program without its log, and of a traceback the exception alone."""
    kept: Lines = []
    is_traceback = False
    for time_s, line in printed:
        if line.startswith(("Traceback", "Exception in thread")):
            is_traceback = True
        elif is_traceback and (line.startswith((" ", "During handling")) or not line):
            continue
        elif not _LOG.match(line):
            is_traceback = False
            kept.append((time_s, _PLACE.sub("", line)))
    return kept


def code_of(code: int | None) -> int | None:
    """Return an exit code as a shell shows it."""
    return 128 - code if code is not None and code < 0 else code


def differences(case: Case, real: Ran, staged: Ran) -> list[str]:
    """Return what differs."""
    differing = []
    theirs, ours = (
        [shown(printed) for printed in real.printed],
        [shown(printed) for printed in staged.printed],
    )
    later = [other - mine for (other, _), (mine, _) in zip(theirs[-1], ours[-1], strict=False)]
    start_s = median(later) if later else 0.0
    begun_s = max((lines[0][0] for lines in theirs if lines), default=0.0) - start_s
    for at, words in enumerate(case.programs):
        name = words.split()[0].removesuffix(".py")
        wrong = _first_difference(
            [(time_s - start_s, line) for time_s, line in theirs[at]],
            ours[at],
            case.period_s + SLACK_S,
            (begun_s, ours[-1][-1][0]) if later else (0.0, 0.0),
        )
        if wrong:
            differing.append(f"{name}: {wrong}")
        codes = code_of(real.codes[at]), code_of(staged.codes[at])
        if codes[0] != codes[1]:
            differing.append(f"{name}: exit code {codes[0]} really, {codes[1]} on the stage")
    return differing


def _first_difference(
    theirs: Lines, ours: Lines, limit_s: float, main_s: tuple[float, float]
) -> str:
    """Return the first difference of lines or times; empty without one.

    Lines of one instant of virtual time may have any order in reality. What comes before each
    program has printed a line waits for processes to start, and what follows the end of the main
    program for SIGINT: they are not timed.
    """
    at = 0
    while at < max(len(theirs), len(ours)):
        here = ours[at : at + 1]
        while here and at + len(here) < len(ours) and ours[at + len(here)][0] == here[0][0]:
            here.append(ours[at + len(here)])
        there = theirs[at : at + max(len(here), 1)]
        if sorted(line for _, line in here) != sorted(line for _, line in there):
            lines = [[line for _, line in printed[at : at + 3]] for printed in (theirs, ours)]
            return f"line {at + 1}: {lines[0]} really, {lines[1]} on the stage"
        late = max(abs(other - here[0][0]) for other, _ in there)
        is_timed = there[0][0] >= main_s[0] and here[0][0] <= main_s[1]
        if is_timed and late > limit_s:
            return f"{here[0][1]!r} {late:.2f} s apart, at {here[0][0]:.2f} s on the stage"
        at += len(here)
    return ""


def trial(number: int) -> Line:
    """Run a case twice; return the line of its results."""
    case = CASES[number]
    with tempfile.TemporaryDirectory() as name:
        try:
            staged = on_the_stage(case, Path(name))
        except Exception as error:  # noqa: BLE001 - this is looked for, too
            return {"number": number, "case": case.name, "findings": [f"error: {error}"]}
        for _ in range(RUNS):
            real = in_real_time(case, Path(name))
            if not (findings := differences(case, real, staged)):
                break
    return {
        "number": number,
        "case": case.name,
        "lines": sum(map(len, real.printed)),
        "seconds": round(staged.printed[-1][-1][0], 2) if staged.printed[-1] else 0.0,
        "findings": findings,
    }


def main() -> None:
    """Run the cases; print a table."""
    options = arguments(__doc__, cases="", jobs=1, results=Path("parity.jsonl"))
    chosen = [at for at, case in enumerate(CASES) if options.cases in case.name]
    numbers = [at for at in missing(options.results, len(CASES)) if at in chosen]
    lines = carry_out(trial, numbers, options.results, options.jobs, silence_logs)
    lines.sort(key=lambda line: line["number"])
    for line in lines:
        print(f"| {line['case']} | {'; '.join(line['findings']) or 'same'} |")
    figure("cases", len(lines))
    figure("same", sum(not line["findings"] for line in lines))
    conclude(lines)


if __name__ == "__main__":
    main()
