"""One attached mission whose processes are killed, stopped or restarted, and its outcome."""

from __future__ import annotations

import json
import os
import re
import signal
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml
from attached_plan import Disturbance, Plan, plan
from safety_kills import TRUTH_PERIOD_S, Truth

from bt_mission.base.wall_clock import Stopwatch
from bt_mission.cli.exits import (
    ABORTED,
    BAD_INPUT,
    CANCELED,
    INTERRUPTED,
    LOST,
    MISSION_FAILED,
    NO_SERVER,
    SUCCESS,
)
from bt_mission.scenarios.faults.errors import ScenarioError
from bt_mission.testing.live_graph import READY, LiveGraph, Process

FIGURE_S = 0.5
"""The base must stand within this time after the last command that moves it was sent."""
STARTED_S, ENDED_S, STOOD_S = 300.0, 180.0, 60.0
"""Seconds of the wall clock until a process must be ready, have ended, and the base stand."""
NOTICED_S = 1.5
"""Seconds after which others must notice a stopped process."""
HEARD_S = 1.0
"""Seconds of the wall clock until every earlier command has been received."""
RESUMED_S = 300.0
"""Seconds until a mission is resumed from its journal, or refused."""
SETTLE_S = 4.0
"""Seconds of the wall clock for which the trial continues after the last disturbance."""
LEASE_S = 4.0
"""Seconds of the wall clock until servers have aborted the goals of a missing executive."""

ACCEPTED = re.compile(r"\.(\w+)\]: goal accepted")
ENDED = re.compile(r"\.(\w+)\]: goal (?:succeeded|aborted|canceled)")
BROKEN = ("Traceback (most", "Fatal Python error", "terminate called", "Segmentation fault")
CODES = {"success": SUCCESS, "failure": MISSION_FAILED, "interrupted": INTERRUPTED}


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

    def wait(self, done: Callable[[], bool], limit_s: float) -> bool:
        """Receive the truth until a condition is true. Return whether it is in time."""
        watch = Stopwatch()
        while not done():
            if watch.elapsed_s > limit_s:
                return False
            self.truth.hear(0.05)
        return True


@dataclass
class Trial:
    """The outcome of a plan."""

    number: int
    plan: str
    disturbed: list[str] = field(default_factory=list)
    ended: str = ""
    reason: str = ""
    resumed: str = ""
    """The outcome of a resumption from the journal, if there was one."""
    stood: list[list[Any]] = field(default_factory=list)
    """After which disturbance the base stood, after how many seconds of ROS time since then, and
    since the last command that moves was sent."""
    load: float = 0.0
    wall_s: float = 0.0
    findings: list[str] = field(default_factory=list)


def carry_out(trial: int) -> Trial:
    """Run a trial."""
    drawn = plan(trial)
    outcome = Trial(trial, str(drawn))
    watch = Stopwatch()
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        live = LiveGraph(folder, int(os.environ["ROS_DOMAIN_ID"]))
        stack.callback(live.close)
        graph = Graph(drawn, live, stack.enter_context(Truth()))
        try:
            _carry_out(graph, outcome)
        except ScenarioError as error:
            outcome.findings.append(f"no start: {error}")
        for process in graph.processes:
            if any(words in process.output for words in BROKEN):
                outcome.findings.append(f"traceback: {process.name}: {process.output[-2000:]}")
        if outcome.findings and (keep := os.environ.get("KEEP_OUTPUT")):
            for process in graph.processes:
                name = f"{trial}_{process.name.replace(' ', '_')}.log"
                (Path(keep) / name).write_text(process.output, encoding="utf-8")
    left = list(_left(os.environ["ROS_DOMAIN_ID"]))
    if left:
        outcome.findings.append(f"processes left: {left}")
    outcome.load = round(os.getloadavg()[0], 1)
    outcome.wall_s = round(watch.elapsed_s, 1)
    return outcome


def _carry_out(graph: Graph, outcome: Trial) -> None:
    drawn = graph.plan
    graph.start("sim")
    if drawn.with_arbiter:
        graph.start("arbiter")
    graph.start("servers").until(READY, within=STARTED_S)
    executive = graph.start("executive")
    if drawn.serves:
        executive.until("waits for missions", within=STARTED_S)
        graph.send()
    if not drawn.is_early:
        servers = graph.running["servers"]
        graph.wait(
            lambda: "goal accepted" in servers.output or executive.code is not None, STARTED_S
        )
    for disturbance in drawn.disturbances:
        graph.wait(lambda: False, disturbance.after_s)
        _disturb(graph, disturbance, outcome)
    graph.wait(lambda: False, SETTLE_S)
    if drawn.awaits_end:
        graph.wait(lambda: graph.running["executive"].code is not None, ENDED_S)
    _end(graph, outcome)


def _disturb(graph: Graph, disturbance: Disturbance, outcome: Trial) -> None:
    process = graph.running[disturbance.process]
    if process.code is not None:
        return
    outcome.disturbed.append(f"{disturbance.what} {disturbance.process}")
    truth = graph.truth
    moved, since_s = truth.seen and not truth.stands(), truth.newest_s
    os.kill(process.pid, signal.SIGSTOP if disturbance.what == "stop" else signal.SIGKILL)
    if disturbance.what != "stop":
        graph.killed.add(process.pid)
        process.wait()
    # A short stop has no effect; without the simulator there is no truth.
    breaks_chain = disturbance.what != "stop" or disturbance.lasts_s > NOTICED_S
    if breaks_chain and graph.running["sim"].code is None and disturbance.process != "sim":
        _watch_base(graph, outcome, since_s, moved=bool(moved))
    if disturbance.what == "kill":
        return
    graph.wait(lambda: False, disturbance.lasts_s)
    if disturbance.what == "stop":
        os.kill(process.pid, signal.SIGCONT)
    elif disturbance.process != "executive":
        if disturbance.process == "sim":
            truth.forget()  # its clock restarts
        graph.start(disturbance.process)
    elif graph.plan.serves:
        graph.start("executive").until("waits for missions", within=STARTED_S)
        graph.send()
    else:
        _resume(graph, outcome)


def _watch_base(graph: Graph, outcome: Trial, since_s: float, *, moved: bool) -> None:
    """Wait until the base stands after the last disturbance, and note when."""
    truth, what = graph.truth, outcome.disturbed[-1]
    if not graph.wait(lambda: truth.stands_since(since_s), STOOD_S):
        newest = f"at {since_s:.2f} s, newest truth {truth.seen[-1:]}"
        outcome.findings.append(f"base goes on: after '{what}' {newest}")
    elif moved:
        truth.hear(HEARD_S)
        stood_s = truth.stood_s()
        after_s = stood_s - truth.commanded_s
        outcome.stood.append([what, round(stood_s - since_s, 3), round(after_s, 3)])
        if after_s > FIGURE_S + TRUTH_PERIOD_S:
            outcome.findings.append(f"base late: stands {after_s:.2f} s after the last command")


def _resume(graph: Graph, outcome: Trial) -> None:
    """Resume from the journal until it is written again, or the reason of a refusal is printed."""
    before = graph.journal_state
    process = graph.start("executive", "--resume")
    reports = graph.wait(
        lambda: process.code is not None or graph.journal_state not in (before, (0, 0)), RESUMED_S
    )
    outcome.resumed = "carries on"
    has_time = all(graph.running[name].code is None for name in ("sim", "servers"))
    if not reports and has_time:
        outcome.findings.append(f"hang: not resumed within {RESUMED_S:g} s: {process.output}")
    graph.wait(lambda: process.code is not None, SETTLE_S)


def _report(process: Process) -> dict[str, Any] | None:
    for line in reversed(process.output.splitlines()):
        if line.startswith('{"mission"'):
            return dict(json.loads(line))
    return None


def _end(graph: Graph, outcome: Trial) -> None:
    executive = graph.running["executive"]
    if executive.pid not in graph.killed:
        _end_executive(graph, executive, outcome)
    else:
        outcome.ended = "killed"
        if not graph.plan.serves:
            _resume(graph, outcome)
            _end_executive(graph, graph.running["executive"], outcome)
    for client in graph.clients:
        _check_client(graph, client, outcome)
    _check_goals(graph, outcome)
    for name in ("servers", "arbiter", "sim"):
        if name in graph.running and graph.running[name].code is None:
            _interrupt(graph, name, outcome)


def _interrupt(graph: Graph, name: str, outcome: Trial) -> None:
    process = graph.running[name]
    process.interrupt()
    if not graph.wait(lambda: process.code is not None, ENDED_S):
        outcome.findings.append(f"hang: {name} does not end")
    elif process.code not in (SUCCESS, INTERRUPTED):  # the latter while it is loaded
        outcome.findings.append(f"exit code: {process.code} of {name} after Ctrl-C")


def _end_executive(graph: Graph, executive: Process, outcome: Trial) -> None:
    was_interrupted = executive.code is None
    if was_interrupted:
        executive.interrupt()
    if not graph.wait(lambda: executive.code is not None, ENDED_S):
        outcome.findings.append(f"hang: the executive does not end: {executive.output[-500:]}")
        return
    code, report = executive.code, _report(executive)
    outcome.ended = f"{outcome.ended} {code}".strip()
    resumes = executive.name.startswith("run ")
    if graph.plan.serves:
        if code != 0:
            outcome.findings.append(f"exit code: {code} of serve: {executive.output[-500:]}")
    elif report is None:
        last = executive.output.strip()[-400:]
        outcome.reason = last.splitlines()[-1] if last else ""
        if resumes:
            outcome.resumed = f"refused: {outcome.reason}"
        is_reported = (code == BAD_INPUT and outcome.reason) or (
            was_interrupted and code == INTERRUPTED
        )
        if not is_reported:
            outcome.findings.append(f"no report, exit code {code}: {last}")
    else:
        outcome.reason = report["reason"]
        if resumes:
            outcome.resumed = f"carried on, {report['status']}: {report['reason']}"[:200]
        servers = [
            process.output for process in graph.processes if process.name.startswith("servers")
        ]
        outcome.findings += check_report(report, code, executive.output, "".join(servers))


def check_report(report: dict[str, Any], code: int | None, output: str, servers: str) -> list[str]:
    """Return false statements of a report: by the exit code, and by the output of both sides."""
    findings = []
    if code != CODES[report["status"]]:
        findings.append(f"exit code: {code} with {report['status']}")
    if report["goals_left_behind"] and "orphaned goals: " not in output:
        findings.append(f"orphans: {report['goals_left_behind']} are not named")
    claimed = sum(leaf["outcomes"].get("succeeded", 0) for leaf in report["leaves"])
    true = servers.count("goal succeeded")
    if claimed > true:
        findings.append(f"untrue: {claimed} goals are said to have succeeded, {true} did")
    return findings


def _check_client(graph: Graph, client: Process, outcome: Trial) -> None:
    """Check that the client of the mission gets its end, or learns that no server is left."""
    if not graph.wait(lambda: client.code is not None, ENDED_S):
        outcome.findings.append(f"hang: the client of serve does not end: {client.output[-500:]}")
        return
    served = "".join(
        process.output for process in graph.processes if process.name.startswith("serve")
    )
    if client.code == SUCCESS and f"{graph.plan.mission}: success" not in served:
        outcome.findings.append("untrue: the client of serve was told of success")
    if client.code not in (SUCCESS, ABORTED, CANCELED, NO_SERVER, LOST):
        outcome.findings.append(f"exit code: {client.code} of a client: {client.output[-500:]}")


def _check_goals(graph: Graph, outcome: Trial) -> None:
    """Check that after the executive's end no goal runs, and the base stands."""
    if graph.running["servers"].code is None:
        ended = graph.wait(lambda: graph.goals()[0] == graph.goals()[1], STOOD_S + LEASE_S)
        if not ended:
            accepted, done = graph.goals()
            outcome.findings.append(f"orphaned goals: {dict(accepted - done)} never end")
    alive = graph.running["sim"].code is None
    if alive and not graph.wait(lambda: not graph.truth.seen or graph.truth.stands(), STOOD_S):
        outcome.findings.append("base moves at the end")


def _left(domain: str) -> Iterator[str]:
    """Return the processes of ours that remain in a domain."""
    for entry in Path("/proc").iterdir():
        if not entry.name.isdecimal() or int(entry.name) == os.getpid():
            continue
        try:
            command = (entry / "cmdline").read_bytes()
            environment = (entry / "environ").read_bytes().split(b"\0")
        except OSError:
            continue
        if b"bt_mission" in command and f"ROS_DOMAIN_ID={domain}".encode() in environment:
            yield command.replace(b"\0", b" ").decode(errors="replace")
