"""The processes of a trial of `campaigns/attached_campaign.py`, and the truth about the base."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import yaml
from attached_plan import Plan
from safety_kills import Truth

from bt_mission.core.wall_clock import Stopwatch
from bt_mission.testing.live_graph import LiveGraph, Process

ACCEPTED = re.compile(r"\.(\w+)\]: goal accepted")
ENDED = re.compile(r"\.(\w+)\]: goal (?:succeeded|aborted|canceled)")


class Graph:
    """The processes of a trial, and the truth about the base."""

    def __init__(self, plan: Plan, graph: LiveGraph, truth: Truth) -> None:
        self.plan = plan
        self._graph = graph
        self.truth = truth
        folder = graph.folder
        self._topic = "cmd_vel_mission" if plan.with_arbiter else "cmd_vel"
        self._parameters = folder / "parameters.yaml"
        values = {"bt_mission_servers": {"ros__parameters": {"topics.cmd_vel": self._topic}}}
        self._parameters.write_text(yaml.safe_dump(values), encoding="utf-8")
        self._mission = plan.mission
        if plan.text:
            path = folder / "missions" / f"{plan.mission}.yaml"
            path.parent.mkdir()
            path.write_text(plan.text, encoding="utf-8")
            self._mission = str(path)
        self.journal = folder / "journal"
        self.running: dict[str, Process] = {}
        self.clients: list[Process] = []
        self.killed: set[int] = set()

    @property
    def processes(self) -> list[Process]:
        """All processes that were started."""
        return self._graph.processes

    def start(self, name: str, *options: str) -> Process:
        """Start a process of the trial."""
        served = ("--missions", str(self._graph.folder / "missions")) if self.plan.text else ()
        commands = {
            "sim": ("sim", "--world", self.plan.world),
            "arbiter": ("arbiter",),
            "servers": ("servers", "--params", str(self._parameters)),
            "executive": ("serve", *served)
            if self.plan.serves
            else ("run", self._mission, "--attach", "--json", "--journal", str(self.journal)),
        }
        images = ("--images", str(self._graph.folder / "images")) if name == "servers" else ()
        camera = ("--no-camera",) if name == "sim" and self.plan.mission != "drawn" else ()
        process = self._graph.start(*commands[name], *images, *camera, *options)
        self.running[name] = process
        return process

    @property
    def journal_state(self) -> tuple[int, int]:
        """Return time and size of the journal's newest transaction: they change with each write."""
        transactions = Path(f"{self.journal}-wal")
        if not transactions.exists():
            return 0, 0
        status = transactions.stat()
        return status.st_mtime_ns, status.st_size

    def send(self) -> None:
        """Send the mission to the serving executive."""
        path = self._mission if self.plan.text else f"{self._mission}.yaml"
        goal = f"{{path: {path}}}"
        self.clients.append(self._graph.start("actions", "send", "/execute_mission", goal))

    def goals(self) -> tuple[Counter[str], Counter[str]]:
        """Return the goals that the present servers accepted, and ended, by action."""
        output = self.running["servers"].output
        return Counter(ACCEPTED.findall(output)), Counter(ENDED.findall(output))

    def until(self, process: Process, words: str, limit_s: float) -> bool:
        """Wait until a process has printed something. Return whether it has."""
        return self.wait(lambda: words in process.output or process.code is not None, limit_s) and (
            words in process.output
        )

    def wait(self, done: Callable[[], bool], limit_s: float) -> bool:
        """Receive the truth until a condition is true. Return whether it is in time."""
        watch = Stopwatch()
        while not done():
            if watch.elapsed_s > limit_s:
                return False
            self.truth.hear(0.05)
        return True
