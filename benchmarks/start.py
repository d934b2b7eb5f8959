"""How soon a command starts: to its first line, to its first step, and without its virtual work.

Each measurement is a process of its own. What is timed on a terminal runs on one of its own (a
pseudo terminal) and is ended as soon as what is waited for has been printed; the first step is the
first line about a leaf of `run --plain`. The virtual work of `run square.yaml --json` is the wall
time that its own report tells for the mission. Modules are compiled beforehand, as an installation
does.
Run it as: python benchmarks/start.py [--rounds N] [--only json|terminal|help ...]
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
from compileall import compile_dir
from functools import partial
from importlib.util import find_spec

from measuring import arguments, figures, in_turns
from terminals import on_terminal

from bt_mission.base.wall_clock import Stopwatch

COMMAND = (sys.executable, "-m", "bt_mission")
LINE = re.compile(rb"[A-Za-z]{3}")
"""Words: what a terminal is sent before them only sets it up."""
NAMED = re.compile(rb"dqn_stage4")
"""The world of `explore.yaml`, which is known once the mission has been read."""
STEP = re.compile(rb"\d s  \S+ \w")
"""A line about a leaf, such as `0.05 s  > side`."""


def compile_modules() -> None:
    """Have the modules of the checkout compiled, and found so by the processes that are started."""
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    for package in ("bt_mission", "action_servers", "sim"):
        spec = find_spec(package)
        for folder in spec.submodule_search_locations or () if spec else ():
            compile_dir(folder, quiet=2)


def to_end(*arguments: str) -> tuple[float, float, bytes]:
    """Run a command. Return wall seconds, processor seconds and its output."""
    with tempfile.TemporaryFile() as output:
        watch = Stopwatch()
        process = subprocess.Popen(  # noqa: S603 - ourselves
            [*COMMAND, *arguments], stdin=subprocess.DEVNULL, stdout=output
        )
        _, status, used = os.wait4(process.pid, 0)
        wall_s = watch.elapsed_s
        process.returncode = os.waitstatus_to_exitcode(status)
        output.seek(0)
        printed = output.read()
    if process.returncode:
        raise SystemExit(f"{' '.join(arguments)}: exit code {process.returncode}")
    return wall_s, used.ru_utime + used.ru_stime, printed


def until(pattern: re.Pattern[bytes], *arguments: str) -> float:
    """Run a command on a terminal until it has printed something. Return wall seconds."""
    watch, seen = Stopwatch(), b""
    with on_terminal(*arguments) as terminal:
        while not pattern.search(seen):
            try:
                seen += os.read(terminal, 65536)
            except OSError:  # it has ended
                raise SystemExit(f"{' '.join(arguments)}: ended with {seen!r}") from None
        return watch.elapsed_s


def of_json(rounds: int) -> dict[str, list[float]]:
    """Return the cost of a process besides its mission."""
    besides_s, used_s = [], []
    for _ in range(rounds):
        wall_s, cpu_s, printed = to_end("run", "missions/square.yaml", "--json")
        besides_s.append(wall_s - float(json.loads(printed)["wall_s"]))
        used_s.append(cpu_s)
    return {
        "square.yaml --json less its virtual work": besides_s,
        "square.yaml --json, whole process, CPU": used_s,
    }


def of_terminal(rounds: int) -> dict[str, list[float]]:
    """Return the time to the first output of `run explore.yaml`, and to the first motion."""
    run = ("run", "missions/explore.yaml")
    works = {
        "first line on a terminal": partial(until, LINE, *run),
        "mission and world are named": partial(until, NAMED, *run),
        "first step": partial(until, STEP, *run, "--plain"),
    }
    return dict(zip(works, in_turns(rounds, *works.values()), strict=True))


def of_help(rounds: int) -> dict[str, list[float]]:
    """Return how long help and completion take, to the end of the process."""
    works = {
        "--help": ("--help",),
        "run --help": ("run", "--help"),
        "completion of a mission's name": ("completion", "--names", "runs"),
        "completion script": ("completion", "bash"),
    }
    walls = in_turns(rounds, *(lambda words=words: to_end(*words)[0] for words in works.values()))
    return dict(zip(works, walls, strict=True))


def main() -> None:
    """Print the table."""
    parts = {"json": of_json, "terminal": of_terminal, "help": of_help}
    options = arguments(__doc__, only=parts, rounds=7)
    # A run must not meet another one of this machine, and the first writes caches.
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    compile_modules()
    for part in options.only:
        named = part(options.rounds)
        figures("bt-mission", {name: (seconds, "s") for name, seconds in named.items()})


if __name__ == "__main__":
    main()
