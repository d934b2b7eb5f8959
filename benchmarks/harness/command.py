"""The command line of `python -m benchmarks`."""

from __future__ import annotations

import argparse
import asyncio
import difflib
import json
import os
import signal
import sys
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from benchmarks.harness.benchmark import Benchmark
from benchmarks.harness.catalogue import CATALOGUE
from benchmarks.harness.measurement import Measurement
from benchmarks.harness.report import (
    about_machine,
    document,
    machine_lines,
    markdown,
    step_table,
)
from benchmarks.harness.running import Plan, Runner, busy
from benchmarks.harness.tree import TreeError, checked_out, this_tree

ALL, TABLE = "all", "table"
DONE, FAILED, MISUSED, INTERRUPTED = 0, 1, 2, 130

DESCRIPTION = """\
Measure what the software costs.

Without a name, the benchmarks are listed. Each is also a script of this folder
that starts by itself (python benchmarks/speed.py --help), with more options.
"""

EPILOG = """\
examples:
  python -m benchmarks                         list all, with one line each
  python -m benchmarks speed goals             run two of them
  python -m benchmarks speed --against main    the commit 'main' beside this one, in turns:
                                               ratios hold on a busy machine, too
  python -m benchmarks table --against HEAD~9 --markdown table.md
                                               the figures that have a target
  python -m benchmarks table --busy 2          the same while two processes compute beside it
  python -m benchmarks all --smoke             does each of them work? under a minute

Progress goes to standard error, tables to standard output. What a target misses is
marked in the tables, and is no error.

exit codes:
  0  all have run          2    something on the command line is wrong
  1  one has failed        130  interrupted; the checkout of --against is removed
"""


class UsageError(Exception):
    """Something on the command line is wrong."""


def parser() -> argparse.ArgumentParser:
    """The options."""
    made = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    made.add_argument(
        "names",
        nargs="*",
        metavar="NAME",
        help=f"benchmarks to run; '{ALL}' is each of them (hours), '{TABLE}' those whose figures "
        "have a target, with a table of these",
    )
    made.add_argument(
        "--rounds",
        type=_count,
        metavar="N",
        help="measurements of each figure, of which median and spread are told "
        "(default: each benchmark's own; 5 with --against)",
    )
    made.add_argument(
        "--smoke",
        action="store_true",
        help="a tiny run of each, several at a time: do they work? Its figures mean nothing",
    )
    made.add_argument(
        "--against",
        metavar="REV",
        help="measure another commit, too, in turns with this checkout, each round in a process of "
        "its own; it is checked out into a temporary folder",
    )
    made.add_argument(
        "--busy",
        type=_count,
        default=0,
        metavar="N",
        help="keep N processes computing beside it, as on a loaded machine",
    )
    made.add_argument("--json", type=Path, metavar="FILE", help="write all values as JSON")
    made.add_argument("--markdown", type=Path, metavar="FILE", help="write the table to a file")
    made.add_argument(
        "--jobs",
        type=_count,
        metavar="N",
        help="with --smoke: how many at a time (default: as many as there are processors)",
    )
    return made


def _count(text: str) -> int:
    try:
        number = int(text)
    except ValueError:
        number = 0
    if number < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number from 1, got '{text}'")
    return number


def main(arguments: Sequence[str] | None = None) -> int:
    """List or run benchmarks; gives the exit code."""
    options = parser().parse_args(arguments)
    try:
        if not options.names:
            _check_listing(options)
            print(listing())
            return DONE
        chosen = choose(options.names)
        _check(options)
        return _carry_out(options, chosen)
    except (UsageError, TreeError) as error:
        print(f"python -m benchmarks: {error}", file=sys.stderr)
        return MISUSED
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED


def listing() -> str:
    """All benchmarks, with one line each."""
    names = max(len(one.name) for one in CATALOGUE)
    times = max(len(one.takes) for one in CATALOGUE)
    lines = [f"  {one.name:{names}}  {one.takes:{times}}  {one.line}" for one in CATALOGUE]
    return "\n".join([*lines, "", "python -m benchmarks NAME ... runs some; --help says more"])


def choose(names: Sequence[str]) -> list[Benchmark]:
    """Find the benchmarks of these names.

    Raises:
        UsageError: Where one is not there, with those that are like it.
    """
    known = {one.name: one for one in CATALOGUE}
    unknown = [name for name in names if name not in (*known, ALL, TABLE)]
    if unknown:
        raise UsageError("; ".join(_no_such(name, [*known, ALL, TABLE]) for name in unknown))
    if TABLE in names and len(names) > 1:
        raise UsageError(f"'{TABLE}' names its benchmarks itself: leave the other names out")
    if TABLE in names:
        return [one for one in CATALOGUE if any(figure.row for figure in one.figures)]
    return list(CATALOGUE) if ALL in names else [known[name] for name in dict.fromkeys(names)]


def _no_such(name: str, known: Sequence[str]) -> str:
    near = difflib.get_close_matches(name.removesuffix(".py").replace("_", "-"), known, n=2)
    meant = f"did you mean {' or '.join(repr(one) for one in near)}?" if near else ""
    hint = meant or "python -m benchmarks lists them"
    return f"there is no benchmark '{name}': {hint}"


def _check_listing(options: argparse.Namespace) -> None:
    """Refuse options that the list would silently ignore."""
    if any((options.smoke, options.against, options.rounds, options.json, options.markdown)):
        raise UsageError(f"name what is to be run, or '{ALL}'; python -m benchmarks lists them")


def _check(options: argparse.Namespace) -> None:
    """Refuse what would fail after hours."""
    for file in (options.json, options.markdown):
        _check_writable(file)
    if options.jobs and not options.smoke:
        raise UsageError("--jobs is for --smoke: benchmarks at the same time spoil each other")


def _check_writable(file: Path | None) -> None:
    if file is None:
        return
    if file.is_dir():
        raise UsageError(f"'{file}' is a folder; name a file in it")
    if not file.absolute().parent.is_dir():
        raise UsageError(f"there is no folder '{file.absolute().parent}' to write '{file.name}' to")


def _carry_out(options: argparse.Namespace, chosen: list[Benchmark]) -> int:
    with ExitStack() as made:
        # As for Ctrl-C: what was started ends, what was checked out goes.
        signal.signal(signal.SIGTERM, lambda *_: signal.raise_signal(signal.SIGINT))
        old = made.enter_context(checked_out(options.against)) if options.against else None
        jobs = (options.jobs or os.cpu_count() or 1) if options.smoke else 1
        plan = Plan(this_tree(), old, options.rounds, smoke=options.smoke, jobs=jobs)
        made.enter_context(busy(options.busy))
        machine = about_machine(options.busy)
        runner, code = Runner(plan, chosen), DONE
        try:
            asyncio.run(runner.run())
        except KeyboardInterrupt:
            code = INTERRUPTED
            print(f"interrupted after {len(runner.done)} of {len(chosen)}", file=sys.stderr)
        machine["load_after"] = round(os.getloadavg()[0], 2)
        _tell(options, sorted(runner.done, key=_place), plan, machine)
    return code or (FAILED if any(one.failures for one in runner.done) else DONE)


def _place(measurement: Measurement) -> int:
    return CATALOGUE.index(measurement.benchmark)


def _tell(
    options: argparse.Namespace,
    measurements: list[Measurement],
    plan: Plan,
    machine: dict[str, object],
) -> None:
    """Print the table, and write the files."""
    as_table = step_table if TABLE in options.names else markdown
    text = as_table(machine_lines(machine, plan), measurements, plan)
    if measurements and not plan.smoke:
        print(f"\n{text}", flush=True)
    if options.markdown:
        options.markdown.write_text(text, encoding="utf-8")
    if options.json:
        found = document(measurements, plan, machine)
        options.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
