"""Whether a mission file gets what it deserves: words with a place, or a run without surprise.

What an accepted mission fails on must be something that nobody could know before: a value that
came out of a message or a draw. Everything else is a finding.
"""

from __future__ import annotations

import sys
from pathlib import Path
from random import Random
from typing import Any
from zlib import crc32

from bt_mission.base import files
from bt_mission.base.diagnostics import Diagnostic, InputError
from bt_mission.base.errors import BtMissionError
from bt_mission.executive.behaviours.builder import build_tree
from bt_mission.executive.behaviours.runtime import MissionFailure, Scope
from bt_mission.executive.executive import Executive
from bt_mission.executive.trace import Trace
from bt_mission.language.mission import Mission
from bt_mission.robots.model import load_robot
from bt_mission.sessions.check import examine
from sim.world.loader import load_world
from tests.support.fuzz.finding import Finding, Verdict, crash
from tests.support.fuzz.foresight import foreseeable
from tests.support.fuzz.graph import Graph

TICKS = 200
NODE_TICKS = 40_000
"""At most so many visits of nodes: large trees get fewer ticks."""

SETTLING_TICKS = 2_000

SHIPPED = frozenset((*files.names("worlds"), *files.names("robots")))
"""Worlds and robots that have tests of their own; to read them takes longer than the check."""


class _Watched(Executive):
    """Keeps the exception that ended the mission."""

    error: BaseException | None = None

    def _end(self, verdict: Any, reason: str) -> None:
        self.error = sys.exception() or self.error
        super()._end(verdict, reason)


def judge(path: Path) -> Verdict:
    """Check a mission file, and run it if it is sound."""
    mission, faults = examine(path)
    wrong = _misplaced(faults)
    if wrong is not None:
        return Verdict(mission is not None, finding=Finding("a fault without a place", wrong))
    if mission is None:
        if not any(fault.severity == "error" for fault in faults):
            return Verdict(accepted=False, finding=Finding("refused without an error", ""))
        return Verdict(accepted=False)
    try:
        if mission.robot not in SHIPPED:
            load_robot(mission.robot, near=mission.file)
        if mission.world and mission.world not in SHIPPED:
            load_world(mission.world, near=mission.file)
    except InputError as error:
        str(error)
        return Verdict(accepted=False)
    return _run(mission, Random(crc32(path.read_bytes())))


def _misplaced(faults: tuple[Diagnostic, ...]) -> str | None:
    str(InputError(faults))
    for fault in faults:
        lines = str(fault).split("\n")
        if not fault.line and fault.message.startswith(("no such file", "expected", "cannot read")):
            continue
        whole = fault.message.startswith("the file is too large") or "UTF-8" in fault.message
        if not whole and (fault.line < 1 or fault.column < 1):
            return str(fault)
        if len(lines) not in (1, 3):
            return str(fault)
    return None


def _run(mission: Mission, luck: Random) -> Verdict:
    graph = Graph(Scope(dict(mission.inputs), mission.seed), luck)
    try:
        root = build_tree(mission, graph.scope)
        executive = _Watched(root, graph, Trace())
    except BtMissionError as error:
        return Verdict(accepted=True, finding=Finding("cannot be set up", str(error)))
    nodes = sum(1 for _ in root.iterate())
    for _ in range(max(3, min(TICKS, NODE_TICKS // nodes))):
        graph.move()
        executive.tick()
        if executive.is_done:
            break
    end = str(executive.status)
    executive.interrupt("enough")
    graph.stop_delaying()
    for _ in range(SETTLING_TICKS):
        if executive.is_done:
            break
        graph.move()
        executive.tick()
    if not executive.is_done:
        return Verdict(True, end, Finding("the mission does not end", executive.reason))
    cause = executive.error
    if isinstance(cause, MissionFailure) and not isinstance(cause.__cause__, BtMissionError | None):
        cause = cause.__cause__  # raised by a leaf in Python
    if isinstance(cause, MissionFailure):
        known = foreseeable(mission, graph.scope, str(cause))
        return Verdict(True, str(cause), Finding(known, str(cause)) if known else None)
    return Verdict(True, end, None if cause is None else crash(cause))
