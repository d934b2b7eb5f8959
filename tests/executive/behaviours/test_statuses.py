"""The statuses of every composite and decorator, tick by tick.

A tree is written with leaves `<a>`, `<b>`, `<c>`: goals of servers that the test plays. A row is a
tick: before it the servers make their moves (`a+` succeeds, `a-` aborts) and the variable `x`
changes (`x=1`), after it the statuses are read from the root down: R running, S success, F failure,
I never run, or halted. Last stand the leaves whose goals were cancelled, in the order of cancels.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import pytest

from tests.support.play import TICK_NS, Play

LEAF = "{action: {name: /\\1, type: bt_mission_interfaces/action/Turn}, name: \\1, timeout: 99}"
HEAD = "mission: test\ninputs: {x: 0, far: 9}\n"


@dataclass
class Case:
    """A tree, what happens in each tick, and whose goals were cancelled in the end."""

    tree: str
    rows: list[tuple[str, str]]
    cancels: str = ""
    first: dict[str, Any] = field(default_factory=dict)


class Theatre:
    """Plays a tree whose servers do as the rows say."""

    def __init__(self, play: Callable[..., Play], case: Case) -> None:
        tree = re.sub(r"<(\w)>", LEAF, case.tree)
        self.played = play(f"  {tree}", HEAD)
        self.played.scope.values.update(case.first)
        self.cancelled: list[str] = []

    def tick(self, moves: str) -> str:
        """Let the servers move, then tick."""
        for move in moves.split():
            if "=" in move:
                name, _, value = move.partition("=")
                self.played.scope.values[name] = int(value)
                continue
            server = self.played.servers[f"/{move[0]}"]
            server.goal.on_result({"+": 4, "-": 6}[move[1]], None)
        letters = self.played.tick()
        for name, server in sorted(self.played.servers.items()):
            if server.goals and server.goal.phase == "sent":
                server.accept()
            new = server.cancels[self.cancelled.count(name[1:]) :]
            for goal in new:
                self.cancelled.append(name[1:])
                goal.on_result(5, None)
        return letters


CASES = {
    # ---- sequence, fallback ---------------------------------------------------------------
    "a sequence goes on in the tick in which a child succeeds": Case(
        "sequence: [<a>, <b>]", [("", "RRI"), ("a+", "RSR"), ("", "RSR"), ("b+", "SSS")]
    ),
    "a sequence fails with its child, and asks no further": Case(
        "sequence: [<a>, <b>]", [("", "RRI"), ("a-", "FFI")]
    ),
    "a loop asks 'until' in the tick in which a round ends": Case(
        "repeat: {until: x > 1}\n  do: <a>",
        [("", "RR"), ("x=2", "RR"), ("x=0 a+", "RS"), ("", "RR"), ("x=2 a+", "SS")],
    ),
    "a loop asks 'while' only before a round": Case(
        "repeat: {while: x < 2}\n  do: <a>",
        [("", "RR"), ("x=2", "RR"), ("x=0 a+", "RS"), ("", "RR"), ("x=2 a+", "RS"), ("", "SS")],
    ),
    "a loop whose condition does not hold runs nothing": Case(
        "repeat: {while: x > 1}\n  do: <a>", [("", "SI")]
    ),
    "a loop fails with its child": Case(
        "repeat: {until: x > 1}\n  do: <a>", [("", "RR"), ("a+", "RS"), ("", "RR"), ("a-", "FF")]
    ),
    "a loop fails when the most rounds do not do": Case(
        "repeat: {until: x > 1, count: 2}\n  do: <a>",
        [("", "RR"), ("a+", "RS"), ("", "RR"), ("a+", "FS")],
    ),
    "a loop succeeds when the most rounds do": Case(
        "repeat: {while: x < 2, count: 2}\n  do: <a>",
        [("", "RR"), ("a+", "RS"), ("", "RR"), ("a+ x=2", "SS")],
    ),
    "a loop begins anew when it is entered again": Case(
        "repeat: {count: 2}\n  do:\n    repeat: {until: x > 1, count: 2}\n    do: <a>",
        [("", "RRR"), ("a+", "RRS"), ("", "RRR"), ("x=2 a+", "RSS"), ("x=0", "RRR")],
        cancels="",
    ),
    "a round that takes no time takes a tick": Case(
        "repeat: {until: x > 1}\n  do: {check: x < 9}", [("", "RS"), ("", "RS"), ("x=2", "SS")]
    ),
    "a finally cleans up after its node, and ends as that": Case(
        "finally: {timeout: 9}\n  do: <a>\n  then: <b>",
        [("", "RRI"), ("a-", "RFR"), ("", "RFR"), ("b+", "FFS")],
    ),
    "a sequence that is run again begins at its first child": Case(
        "repeat: {count: 2}\n  do:\n    sequence: [<a>, <b>]",
        [
            ("", "RRRI"),
            ("a+", "RRSR"),
            ("b+", "RSSS"),
            ("", "RRRI"),
            ("a+", "RRSR"),
            ("b+", "SSSS"),
        ],
    ),
    "a reactive sequence asks its first child again in each tick": Case(
        "sequence: [{check: x > 0}, <a>]\n  memory: false",
        [("", "RSR"), ("x=2", "RSR"), ("x=0", "FFI")],
        cancels="a",
        first={"x": 1},
    ),
    "a reactive sequence starts an action anew that has ended": Case(
        "sequence: [<a>, <b>]\n  memory: false",
        [("", "RRI"), ("a+", "RSR"), ("", "RRI"), ("", "RRI"), ("a+", "RSR")],
        cancels="b",
    ),
    "a fallback goes on in the tick in which a child fails": Case(
        "fallback: [<a>, <b>]", [("", "RRI"), ("a-", "RFR"), ("b-", "FIF")]
    ),
    "a fallback succeeds with its child, and asks no further": Case(
        "fallback: [<a>, <b>]", [("", "RRI"), ("a+", "SSI")]
    ),
    "a fallback does not ask again what has failed, and forgets its status (py_trees)": Case(
        "fallback: [{check: x > 0}, <a>]",
        [("", "RFR"), ("x=1", "RIR"), ("a+", "SIS")],
        first={"x": 0},
    ),
    "a reactive fallback interrupts what runs, and cancels its goal": Case(
        "fallback: [{check: x > 0}, <a>]\n  memory: false",
        [("", "RFR"), ("", "RFR"), ("x=1", "SSI")],
        cancels="a",
        first={"x": 0},
    ),
    "an interrupted branch deep below is halted as a whole": Case(
        "fallback: [{check: x > 0}, {sequence: [<a>, {parallel: [<b>, <c>]}]}]\n  memory: false",
        [("", "RFRRIII"), ("a+", "RFRSRRR"), ("x=1", "SSIIIII")],
        cancels="bc",
        first={"x": 0},
    ),
    # ---- parallel -------------------------------------------------------------------------
    "a parallel of all waits for the last": Case(
        "parallel: [<a>, <b>]", [("", "RRR"), ("a+", "RSR"), ("", "RSR"), ("b+", "SSS")]
    ),
    "a parallel of all fails with the first failure, and halts the rest": Case(
        "parallel: [<a>, <b>, <c>]", [("", "RRRR"), ("a+", "RSRR"), ("c-", "FSIF")], cancels="b"
    ),
    "a parallel of any halts the rest": Case(
        "parallel: [<a>, <b>]\n  succeed_when: any", [("", "RRR"), ("b+", "SIS")], cancels="a"
    ),
    "a parallel of any fails with a failure, unless said otherwise": Case(
        "parallel: [<a>, <b>]\n  succeed_when: any", [("", "RRR"), ("b-", "FIF")], cancels="a"
    ),
    "with fail_when impossible, any goes on until none is left": Case(
        "parallel: [<a>, <b>]\n  succeed_when: any\n  fail_when: impossible",
        [("", "RRR"), ("b-", "RRF"), ("", "RRF"), ("a-", "FFF")],
    ),
    "with fail_when impossible, any may still succeed": Case(
        "parallel: [<a>, <b>]\n  succeed_when: any\n  fail_when: impossible",
        [("", "RRR"), ("b-", "RRF"), ("a+", "SSF")],
    ),
    "with fail_when impossible, all fails with the first failure all the same": Case(
        "parallel: [<a>, <b>]\n  fail_when: impossible", [("", "RRR"), ("b-", "FIF")], cancels="a"
    ),
    "a parallel of named children needs those alone": Case(
        "parallel: [<a>, <b>, <c>]\n  succeed_when: [a, b]",
        [("", "RRRR"), ("a+", "RSRR"), ("b+", "SSSI")],
        cancels="c",
    ),
    "a failure of a child that is not needed fails a parallel of named ones": Case(
        "parallel: [<a>, <b>, <c>]\n  succeed_when: [a, b]",
        [("", "RRRR"), ("c-", "FIIF")],
        cancels="ab",
    ),
    "unless it fails only when that is impossible": Case(
        "parallel: [<a>, <b>, <c>]\n  succeed_when: [a, b]\n  fail_when: impossible",
        [("", "RRRR"), ("c-", "RRRF"), ("a-", "FFIF")],
        cancels="b",
    ),
    "the rest may finish after a success": Case(
        "parallel: [<a>, <b>]\n  succeed_when: any\n  rest: finish",
        [("", "RRR"), ("a+", "RSR"), ("", "RSR"), ("b-", "SSF")],
    ),
    "the rest may finish after a failure": Case(
        "parallel: [<a>, <b>]\n  rest: finish", [("", "RRR"), ("a-", "RFR"), ("b+", "FFS")]
    ),
    "a parallel that is run again asks all children again": Case(
        "repeat: {count: 2}\n  do:\n    parallel: [<a>, <b>]",
        [("", "RRRR"), ("a+", "RRSR"), ("b+", "RSSS"), ("", "RRRR"), ("a+ b+", "SSSS")],
    ),
    # ---- choose, when ---------------------------------------------------------------------
    "choose runs one child, and ends as that one": Case(
        "choose: [<a>, <b>]\n  weights: [1, 0.0000001]", [("", "RRI"), ("", "RRI"), ("a-", "FFI")]
    ),
    "when runs its node if the condition holds at entry, and asks no more": Case(
        "when: x > 0\n  do: <a>\n  else: <b>",
        [("", "RRI"), ("x=0", "RRI"), ("a+", "SSI")],
        first={"x": 1},
    ),
    "when runs the other one if not": Case(
        "when: x > 0\n  do: <a>\n  else: <b>",
        [("", "RIR"), ("x=1", "RIR"), ("b-", "FIF")],
        first={"x": 0},
    ),
    "when without else succeeds at once": Case(
        "when: x > 0\n  do: <a>", [("", "SI")], first={"x": 0}
    ),
    "when is asked again when it is run again": Case(
        "repeat: {count: 2}\n  do:\n    when: x > 0\n    do: <a>\n    else: <b>",
        [("", "RRIR"), ("b+", "RSIS"), ("x=1", "RRRI"), ("a+", "SSSI")],
        first={"x": 0},
    ),
    # ---- decorators -----------------------------------------------------------------------
    "repeat begins a new round in the next tick": Case(
        "repeat: {count: 2}\n  do: <a>", [("", "RR"), ("a+", "RS"), ("", "RR"), ("a+", "SS")]
    ),
    "repeat fails with its child": Case(
        "repeat: {count: 2}\n  do: <a>", [("", "RR"), ("a+", "RS"), ("", "RR"), ("a-", "FF")]
    ),
    "retry begins a new attempt in the next tick": Case(
        "retry: {attempts: 2}\n  do: <a>", [("", "RR"), ("a-", "RF"), ("", "RR"), ("a+", "SS")]
    ),
    "retry fails with the last attempt": Case(
        "retry: {attempts: 2}\n  do: <a>", [("", "RR"), ("a-", "RF"), ("", "RR"), ("a-", "FF")]
    ),
    "retry pauses between": Case(
        "retry: {attempts: 2, pause: 0.1}\n  do: <a>",
        [("", "RR"), ("a-", "RF"), ("", "RF"), ("", "RR"), ("a+", "SS")],
    ),
    "timeout halts what still runs after its time": Case(
        "timeout: 0.1\n  do: <a>", [("", "RR"), ("", "RR"), ("", "FI")], cancels="a"
    ),
    "timeout lets pass what ends on the tick of the deadline": Case(
        "timeout: 0.1\n  do: <a>", [("", "RR"), ("", "RR"), ("a+", "SS")]
    ),
    "timeout begins anew when it is run again": Case(
        "repeat: {count: 2}\n  do:\n    timeout: 0.1\n    do: <a>",
        [("", "RRR"), ("a+", "RSS"), ("", "RRR"), ("", "RRR"), ("", "FFI")],
        cancels="a",
    ),
    "invert turns either end": Case(
        "sequence: [{invert: <a>}, {invert: <b>}]",
        [("", "RRRII"), ("a-", "RSFRR"), ("b+", "FSFFS")],
    ),
    "force takes a failure for a success": Case(
        "force: success\n  do: <a>", [("", "RR"), ("a-", "SF")]
    ),
    "force takes a success for a failure": Case(
        "force: failure\n  do: <a>", [("", "RR"), ("a+", "FS")]
    ),
    "guard halts its child in the tick in which the condition stops holding": Case(
        "guard: x > 0\n  do: <a>",
        [("", "RR"), ("", "RR"), ("x=0", "FI")],
        cancels="a",
        first={"x": 1},
    ),
    "guard ends with its child while the condition holds": Case(
        "guard: x > 0\n  do: <a>", [("", "RR"), ("a-", "FF")], first={"x": 1}
    ),
    "guard does not begin its child without the condition": Case(
        "guard: x > 0\n  do: <a>", [("", "FI")], first={"x": 0}
    ),
    "for_each runs its child for each element": Case(
        "for_each: {n: [1, 2]}\n  do: <a>", [("", "RR"), ("a+", "RS"), ("", "RR"), ("a+", "SS")]
    ),
    "for_each fails with its child": Case(
        "for_each: {n: [1, 2]}\n  do: <a>", [("", "RR"), ("a-", "FF")]
    ),
    "for_each of nothing succeeds": Case("for_each: {n: []}\n  do: <a>", [("", "SI")]),
    # ---- halted in the middle -------------------------------------------------------------
    **{
        f"{kind} is halted in the middle, and its goals are cancelled": Case(
            f"fallback:\n    - check: x > 0\n    - {tree}\n  memory: false",
            [("", f"RF{before}"), ("x=1", "SS" + "I" * len(before))],
            cancels=cancels,
            first={"x": 0},
        )
        for kind, tree, before, cancels in [
            ("sequence", "sequence: [<a>, <b>]", "RRI", "a"),
            ("a reactive sequence", "{sequence: [<a>, <b>], memory: false}", "RRI", "a"),
            ("fallback", "fallback: [<a>, <b>]", "RRI", "a"),
            ("parallel", "parallel: [<a>, <b>]", "RRR", "ab"),
            ("choose", "choose: [<a>]", "RR", "a"),
            ("when", "{when: x < 1, do: <a>, else: <b>}", "RRI", "a"),
            ("repeat", "{repeat: {count: 2}, do: <a>}", "RR", "a"),
            ("a repeat with a condition", "{repeat: {until: x > 5}, do: <a>}", "RR", "a"),
            ("retry", "{retry: {attempts: 2}, do: <a>}", "RR", "a"),
            ("timeout", "{timeout: 9, do: <a>}", "RR", "a"),
            ("invert", "invert: <a>", "RR", "a"),
            ("force", "{force: success, do: <a>}", "RR", "a"),
            ("guard", "{guard: far > 1, do: <a>}", "RR", "a"),
            ("for_each", "{for_each: {n: [1]}, do: <a>}", "RR", "a"),
        ]
    },
}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_statuses(play: Callable[..., Play], case: Case) -> None:
    """As the table says, and no goal is left behind."""
    theatre = Theatre(play, case)
    assert [theatre.tick(moves) for moves, _ in case.rows] == [row for _, row in case.rows]
    assert "".join(theatre.cancelled) == case.cancels
    theatre.played.executive.interrupt("the end of the test")
    for _ in range(3):
        theatre.tick("")
    assert theatre.played.executive.goals_left_behind == ()
    assert theatre.played.executive.is_done


def test_the_tables_are_in_whole_ticks() -> None:
    """0.1 s are two ticks of 20 Hz."""
    assert TICK_NS * 2 == 100_000_000
