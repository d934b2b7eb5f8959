"""The command line of `python -m benchmarks`."""

from __future__ import annotations

import argparse
import asyncio
import difflib
import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from contextlib import ExitStack

from benchmarks.harness.catalogue import CATALOGUE, Benchmark
from benchmarks.harness.report import machine_line, markdown
from benchmarks.harness.running import Plan, Runner
from benchmarks.harness.tree import TreeError, checked_out, this_tree

ALL, TABLE = "all", "table"
DONE, FAILED, MISUSED, INTERRUPTED = 0, 1, 2, 130
BUSY = "while True: sum(range(10_000))"

EPILOG = """\
examples:
  python -m benchmarks                         list all, with one line each
  python -m benchmarks speed goals             run two of them
  python -m benchmarks speed --against main    the commit 'main' beside this one, in turns:
                                               ratios hold on a busy machine, too
  python -m benchmarks table --against HEAD~9  the figures that have a target
  python -m benchmarks table --busy 2          the same while two processes compute beside it
  python -m benchmarks all --smoke             does each of them work?

Progress goes to standard error, the table to standard output. A target that is missed is marked
in the table, and is no error. Each is also a script with more options: python
benchmarks/speed.py --help

exit codes:
  0  all have run          2    something on the command line is wrong
  1  one has failed        130  interrupted; the checkout of --against is removed
"""


class UsageError(Exception):
    """Something on the command line is wrong."""


def parser() -> argparse.ArgumentParser:
    """Return the options."""
    made = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description="Measure speed (benchmarks) and look for what is wrong (campaigns).",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = made.add_argument
    add(
        "names",
        nargs="*",
        metavar="NAME",
        help=f"what to run; '{ALL}' is each (hours), '{TABLE}' those of the table of targets",
    )
    add("--rounds", type=_count, metavar="N", help="measurements (default: each benchmark's own)")
    add("--smoke", action="store_true", help="a tiny run of each, several at a time: do they work?")
    add("--against", metavar="REV", help="measure another commit, too, in turns with this checkout")
    add("--busy", type=_count, default=0, metavar="N", help="N processes that compute beside it")
    return made


def _count(text: str) -> int:
    number = int(text) if text.isdecimal() else 0
    if number < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number from 1, got '{text}'")
    return number


def main(arguments: Sequence[str] | None = None) -> int:
    """List or run benchmarks. Return the exit code."""
    command_line = parser()
    options = command_line.parse_args(arguments)
    if not options.names and (options.smoke or options.against or options.rounds):
        command_line.error(f"name what to run, or '{ALL}'; python -m benchmarks lists them")
    try:
        chosen = choose(options.names)
        if chosen:
            return run(options, chosen)
        print(listing())
    except (UsageError, TreeError) as error:
        print(f"python -m benchmarks: {error}", file=sys.stderr)
        return MISUSED
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED
    return DONE


def listing() -> str:
    """Return all benchmarks, with one line each."""
    names = max(len(benchmark.name) for benchmark in CATALOGUE)
    times = max(len(benchmark.takes) for benchmark in CATALOGUE)
    lines = [
        f"  {benchmark.name:{names}}  {benchmark.takes:{times}}  {benchmark.line}"
        for benchmark in CATALOGUE
    ]
    return "\n".join([*lines, "", "python -m benchmarks NAME ... runs some; --help says more"])


def choose(names: Sequence[str]) -> list[Benchmark]:
    """Return the benchmarks of these names.

    Raises:
        UsageError: Where a name is unknown; with names that are similar.
    """
    known = {benchmark.name: benchmark for benchmark in CATALOGUE}
    words = [*known, ALL, TABLE]
    for name in names:
        if name not in words:
            near = difflib.get_close_matches(name.removesuffix(".py").replace("_", "-"), words, n=2)
            meant = f"did you mean {' or '.join(map(repr, near))}?"
            hint = meant if near else "python -m benchmarks lists them"
            raise UsageError(f"there is no benchmark '{name}': {hint}")
    if TABLE in names and len(names) > 1:
        raise UsageError(f"'{TABLE}' chooses its benchmarks: leave the other names out")
    if TABLE in names:
        return [benchmark for benchmark in CATALOGUE if benchmark.in_table]
    return list(CATALOGUE) if ALL in names else [known[name] for name in dict.fromkeys(names)]


def run(options: argparse.Namespace, chosen: Sequence[Benchmark]) -> int:
    """Run benchmarks, and print the table. Return the exit code."""
    with ExitStack() as stack:
        # As for Ctrl-C: processes end, and the checkout is removed.
        signal.signal(signal.SIGTERM, lambda *_: signal.raise_signal(signal.SIGINT))
        old = stack.enter_context(checked_out(options.against)) if options.against else None
        jobs = (os.cpu_count() or 1) if options.smoke else 1
        plan = Plan(this_tree(), old, options.rounds, smoke=options.smoke, jobs=jobs)
        for _ in range(options.busy):
            beside = subprocess.Popen([sys.executable, "-S", "-c", BUSY])  # noqa: S603 - ourselves
            stack.callback(beside.wait)
            stack.callback(beside.kill)
        load_before = os.getloadavg()[0]
        runner, code = Runner(plan, chosen), DONE
        try:
            asyncio.run(runner.run())
        except KeyboardInterrupt:
            code = INTERRUPTED
            print(f"interrupted after {len(runner.done)} of {len(chosen)}", file=sys.stderr)
        done = sorted(runner.done, key=lambda measurement: CATALOGUE.index(measurement.benchmark))
        machine = machine_line(plan, load_before, options.busy)
        if done and not plan.smoke:
            print("\n" + markdown(done, plan, machine, with_target=TABLE in options.names))
    return code or (FAILED if any(measurement.failures for measurement in done) else DONE)
