"""Executives that live on a busy machine: how often their servers hold the base, or give them up.

In each of several ROS graphs sim and servers are processes, and attached missions run one after the
other; beside them run processes that do nothing but compute. Each mission is one line of the
results, so a second run goes on where the first was stopped.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from pathlib import Path

from bt_mission.testing.live_graph import LiveGraph, command, own_domain

MISSION = """\
mission: turn
world: empty_arena
tree:
  turn: {angle: 360, angular_velocity: 1}
  timeout: 120
  server_timeout: 60
  acceptance_timeout: 30
"""
BUSY = 8
LIMIT_S = 180.0
"""Seconds of the wall clock for one mission."""
AT_ONCE = 50
"""Missions of one graph, before another takes its place."""


@dataclass(frozen=True)
class Attached:
    """What became of a mission whose executive lived all the time."""

    reason: str
    """Why it has failed; empty if it has not."""
    held: int
    """How often the base was held."""
    load: float
    """Mean load of the machine in the last minute."""

    @property
    def is_given_up(self) -> bool:
        """Whether the servers took its executive for dead."""
        return any(words in self.reason for words in ("sign of life", "the executive has"))


def alarms(runs: int, busy: int, graphs: int, results: Path) -> list[Attached]:
    """Run missions until there are results of so many, in so many graphs at a time."""
    results.touch()
    missing = max(runs - len(read(results)), 0)
    todo = [
        (min(AT_ONCE, missing - begin), results.resolve()) for begin in range(0, missing, AT_ONCE)
    ]
    with _busy(busy), get_context("spawn").Pool(graphs) as pool:
        pool.starmap(_missions, todo, chunksize=1)
    return read(results)


def read(results: Path) -> list[Attached]:
    """The results so far."""
    return [Attached(**json.loads(line)) for line in results.read_text().splitlines()]


def _missions(count: int, results: Path) -> None:
    """Run missions one after the other in a graph of its own, and write down each."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        mission = folder / "turn.yaml"
        mission.write_text(MISSION, encoding="utf-8")
        graph = LiveGraph(folder, stack.enter_context(own_domain()))
        stack.callback(graph.close)
        graph.start("sim", "--world", "empty_arena", "--no-camera")
        servers = graph.start("servers", "--images", str(folder / "images"))
        for _ in range(count):
            before = servers.output.count("the base is held")
            reason = _run(mission, graph.environment)
            held = servers.output.count("the base is held") - before
            line = json.dumps(asdict(Attached(reason, held, os.getloadavg()[0])))
            with results.open("a", encoding="utf-8") as lines:
                lines.write(f"{line}\n")


def _run(mission: Path, environment: dict[str, str]) -> str:
    """Return why a mission has failed; empty if it has not."""
    try:
        done = subprocess.run(  # noqa: S603 - starts our own program
            command("run", str(mission), "--attach", "--json"),
            env=os.environ | environment,
            capture_output=True,
            check=False,
            text=True,
            timeout=LIMIT_S,
        )
    except subprocess.TimeoutExpired:
        return f"not done within {LIMIT_S:g} s"
    try:
        report = json.loads(done.stdout)
    except ValueError:
        return f"no report: {done.stderr.strip()[-200:]}"
    return "" if report["status"] == "success" else str(report["reason"])


@contextmanager
def _busy(count: int) -> Iterator[None]:
    with ExitStack() as stack:
        for _ in range(count):
            process = subprocess.Popen([sys.executable, "-c", "while True: pass"])
            stack.callback(process.wait)
            stack.callback(process.kill)
        yield
