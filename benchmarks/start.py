"""How long commands take to start: help, completion, the first line and the first step of a run.

Run it as: python benchmarks/start.py [--rounds 7] [--against FOLDER]. FOLDER is another checkout,
such as one made by git worktree; both take turns, and its figures stand beside ours.
"""

from __future__ import annotations

import argparse
import os
import pty
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from measuring import in_turns, spread, table

from bt_mission.core.wall_clock import Stopwatch

HERE = Path(__file__).resolve().parent.parent
RUN = ("run", "square", "--json")
SHORT = "short.yaml"
MISSION = "mission: short\nworld: empty_arena\ntree: {wait: 0.1}\n"
"""Next to no work: what remains is the start and the end of the process."""

STEP = "▶".encode()
"""What plain lines put before a node that begins to run."""


def started(tree: Path) -> dict[str, str]:
    """Return the environment in which the sources of a checkout are used, compiled as they are."""
    changed = {"PYTHONPATH": str(tree), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    return {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"} | changed


def command(tree: Path, folder: str, *words: str) -> tuple[float, float]:
    """Run a command; return its wall time and its CPU time, ms."""
    before, watch = resource.getrusage(resource.RUSAGE_CHILDREN), Stopwatch()
    subprocess.run(  # noqa: S603 - our own program
        [sys.executable, "-m", "bt_mission", *words],
        cwd=folder,
        env=started(tree),
        capture_output=True,
        check=True,
    )
    wall, after = watch.elapsed_s, resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return 1000 * wall, 1000 * cpu


def on_terminal(tree: Path, folder: str, until: bytes) -> float:
    """Return the wall time until a run on a terminal has shown some text, ms."""
    ours, theirs = pty.openpty()
    watch, shown = Stopwatch(), b""
    with subprocess.Popen(
        [sys.executable, "-m", "bt_mission", "run", "square", "--plain"],
        cwd=folder,
        env=started(tree),
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
    ) as process:
        os.close(theirs)
        while until not in shown:
            shown += os.read(ours, 4096)
        elapsed = 1000 * watch.elapsed_s
        process.kill()
    os.close(ours)
    return elapsed


def cpu_of(*words: str) -> Callable[[Path, str], float]:
    """Return what measures the CPU time of a command, ms."""
    return lambda tree, folder: command(tree, folder, *words)[1]


MEASURED: dict[str, Callable[[Path, str], float]] = {
    "`--help`, CPU": cpu_of("--help"),
    "`run --help`, CPU": cpu_of("run", "--help"),
    "`completion --names runs`, CPU": cpu_of("completion", "--names", "runs"),
    "`completion bash`, CPU": cpu_of("completion", "bash"),
    "`check square`, CPU": cpu_of("check", "square"),
    "`run square`: first line on a terminal, wall": lambda t, f: on_terminal(t, f, b"\n"),
    "`run square`: first step on a terminal, wall": lambda t, f: on_terminal(t, f, STEP),
    "`run square --json`, whole process, CPU": cpu_of(*RUN),
    "a run of 0.1 s, whole process, CPU": cpu_of("run", SHORT, "--json"),
    "a run of 0.1 s, whole process, wall": lambda t, f: command(t, f, "run", SHORT, "--json")[0],
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--against", type=Path, metavar="FOLDER", help="another checkout")
    options = parser.parse_args(arguments)
    trees = [HERE, *([options.against.resolve()] if options.against else [])]
    rows: list[list[object]] = []
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, SHORT).write_text(MISSION, encoding="utf-8")
        for name, measure in MEASURED.items():
            works = [lambda tree=tree, measure=measure: measure(tree, folder) for tree in trees]
            for work in works:
                work()  # modules are compiled
            found = in_turns(options.rounds, *works)
            rows.append([name, *(spread(one, 0, "ms") for one in found)])
    head = ("to start", "here", *(str(one) for one in trees[1:]))
    table(head, rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
