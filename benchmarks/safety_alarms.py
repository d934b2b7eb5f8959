"""Executives that live on a busy machine: how often their servers hold the base, or give them up.

Sim and servers are processes; attached missions run one after the other, beside processes that do
nothing but compute.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from safety_kills import process

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


@dataclass(frozen=True)
class Alarms:
    """What became of missions whose executive lived all the time."""

    runs: int
    succeeded: int
    held: int
    """How often the base was held, in all of them."""
    given_up: int
    """Missions that failed since the servers took their executive for dead."""
    busy: int
    load: float
    """Mean load of the machine in the last minute of the runs."""
    others: tuple[str, ...]
    """Reasons of the other failures."""


def alarms(runs: int, busy: int = BUSY) -> Alarms:
    """Run missions beside so many busy processes."""
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        mission, log = folder / "turn.yaml", folder / "servers.log"
        mission.write_text(MISSION, encoding="utf-8")
        stack.enter_context(process("sim", "--world", "empty_arena", "--no-camera"))
        with log.open("wb") as out:
            images = str(folder / "images")
            stack.enter_context(process("servers", "--images", images, log=out))
        stack.enter_context(_busy(busy))
        reasons = [_run(mission) for _ in range(runs)]
        load = os.getloadavg()[0]
        text = log.read_text(encoding="utf-8")
    given_up = sum("sign of life" in reason for reason in reasons)
    others = tuple(one for one in reasons if one and "sign of life" not in one)
    held = text.count("the base is held")
    return Alarms(runs, reasons.count(""), held, given_up, busy, load, others)


def _run(mission: Path) -> str:
    """Return why a mission has failed; empty if it has not."""
    arguments = [sys.executable, "-m", "bt_mission", "run", str(mission), "--attach", "--json"]
    try:
        done = subprocess.run(  # noqa: S603 - starts our own program
            arguments, capture_output=True, check=False, text=True, timeout=LIMIT_S
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
            one = subprocess.Popen([sys.executable, "-c", "while True: pass"])
            stack.callback(one.wait)
            stack.callback(one.kill)
        yield
