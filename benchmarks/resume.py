"""explore.yaml killed at ten points and resumed, with sim and servers as processes of their own.

Run it as: python benchmarks/resume.py [--speed 4]

The points are spread over the lines that a run prints, one for each leaf that starts or ends. At
every second point the process lives a moment longer, so that the robot drives when it dies.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from measuring import NOT_SOUND, figure

from bt_mission.core.dds.discovery import RANGE

MISSION, WORLD = "missions/explore.yaml", "dqn_stage4"
POINTS = 10
LINES = 26
"""What an uninterrupted run of explore.yaml with seed 7 prints about its leaves."""

A_MOMENT_S = 0.3
LEFT = "orphaned"
LEG = re.compile(r"^ *[\d.]+ s  ✓ drive", re.MULTILINE)
LEAF = re.compile(r"^ *[\d.]+ s  \S ")


@contextmanager
def process(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    """``bt-mission`` in a process; it is killed at the end."""
    environment = os.environ | {RANGE: "LOCALHOST"}
    command = [sys.executable, "-u", "-m", "bt_mission", *arguments]
    with subprocess.Popen(  # noqa: S603 - our own command line
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as started:
        try:
            yield started
        finally:
            started.kill()


def read_lines(run: subprocess.Popen[str], count: int) -> list[str]:
    """What a run prints until it has said so many things about leaves."""
    assert run.stdout is not None
    seen: list[str] = []
    for line in run.stdout:
        seen.append(line)
        if sum(bool(LEAF.match(one)) for one in seen) == count:
            break
    return seen


def trial(number: int, options: argparse.Namespace, folder: Path) -> tuple[str, str, str]:
    """Kill at the line of that number and go on; gives that line, and the outputs of both runs."""
    with ExitStack() as stack:
        sim = ("sim", "--world", options.world, "--speed", options.speed)
        stack.enter_context(process(*sim))
        servers = stack.enter_context(process("servers", "--images", str(folder / "images")))
        assert servers.stdout is not None
        next(line for line in servers.stdout if "ready: " in line)
        run = ("run", options.mission, "--attach", "--plain")
        run += ("--journal", str(folder / f"{number}.journal"))
        first = stack.enter_context(process(*run))
        before = read_lines(first, number)
        if number % 2:
            with suppress(subprocess.TimeoutExpired):
                first.wait(A_MOMENT_S)
        first.kill()
        assert first.stdout is not None
        before.append(first.stdout.read())
        second = stack.enter_context(process(*run, "--resume"))
        after, _ = second.communicate()
    return before[-2].strip(), "".join(before), after


def main() -> None:
    """Kill, resume, and say what came of each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--speed", default="4", help="of the simulation")
    parser.add_argument("--points", type=int, default=POINTS, help="at which it is killed")
    parser.add_argument("--mission", default=MISSION, help="the file of another one")
    parser.add_argument("--world", default=WORLD, help="of the simulation")
    options = parser.parse_args()
    sound = 0
    with tempfile.TemporaryDirectory() as folder:
        for point in range(1, options.points + 1):
            number = round(point * (LINES - 1) / max(options.points, POINTS))
            line, before, after = trial(number, options, Path(folder))
            legs = len(LEG.findall(before)) + len(LEG.findall(after))
            said = [one.strip() for one in after.splitlines()]
            ended = [one for one in said if ": success" in one or LEFT in one]
            sound += len(ended) > 1 and ended[0].endswith(": success") and f" 0 {LEFT}" in ended[-1]
            print(f"{point:2}: killed after '{line}'")
            print(f"    {' | '.join(ended or said[-3:])}, {legs} legs in all", flush=True)
    figure("share that ended with success", sound / options.points)
    print(f"{sound} of {options.points} ended with success and 0 goals orphaned")
    raise SystemExit(0 if sound == options.points else NOT_SOUND)


if __name__ == "__main__":
    main()
