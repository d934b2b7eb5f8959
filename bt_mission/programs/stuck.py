"""Calls of programs that can never continue."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from rclpy.action import ActionClient
from rclpy.client import Client

from bt_mission.base.errors import BtMissionError
from bt_mission.programs.calls import Call, Program
from bt_mission.programs.executors import SPINS, ProgramExecutor
from bt_mission.programs.places import frames_of, what_of

_ANSWERED = {
    ("rclpy.client", "call"),
    ("rclpy.action.client", "send_goal"),
    ("rclpy.action.client", "_cancel_goal"),
    ("rclpy.action.client", "_get_result"),
}
"""Functions that wait for an answer to ``self``, a client."""


class DeadlockError(BtMissionError):
    """Code of a program waits for what can never happen."""

    code = "BT-919"


def find_stuck(
    calls: Iterable[Call],
    known: set[Call],
    holders_of: Callable[[Any], Sequence[Call]],
    executors_of: Callable[[Program], Sequence[ProgramExecutor]],
) -> None:
    """Look for calls that wait for each other, or for what none of their program can do.

    Args:
        calls: All that have begun and not ended.
        known: Those that were named before; the new ones are added.
        holders_of: Returns the calls that hold a callback group.
        executors_of: Returns the executors of a program that have nodes.

    Raises:
        DeadlockError: With what each of them waits for.
    """
    waiting = [
        call
        for call in calls
        if call.wait is not None and not call.wait.over.is_over and call not in known
    ]
    for call in waiting:
        assert call.wait is not None, "it waits"
        if call.wait.was_checked:
            continue  # whatever closes a circle begins to wait later
        call.wait.was_checked = True
        if (chain := _circle(holders_of, call)) is not None:
            known.update(chain)
            raise DeadlockError(_text(chain, ""))
    mine: dict[Program, list[Call]] = {}
    for call in waiting:
        mine.setdefault(call.program, []).append(call)
    for program, own in mine.items():
        if not _can_continue(program, calls, own):
            executors = executors_of(program)
            if all(executor.free() is None for executor in executors):
                known.update(own)
                raise DeadlockError(_text(own, _remedy(executors)))


def refuse_standstill(calls: Iterable[Call]) -> None:
    """Refuse that nothing will ever be due while calls wait.

    Raises:
        DeadlockError: With what each of them waits for.
    """
    waiting = [
        call
        for call in calls
        if call.wait is not None and not call.wait.over.is_over and call.wait.what != SPINS
    ]
    if waiting:
        raise DeadlockError(_text(waiting, "; nothing else will ever happen"))


def _remedy(executors: Sequence[ProgramExecutor]) -> str:
    """Say why nothing is served, and what to do."""
    if not any(executor.is_spinning for executor in executors):
        return "; nothing spins its executors any more"
    several = any(executor.hands_over for executor in executors)
    advice = "one with more threads" if several else "a MultiThreadedExecutor"
    return f"; no thread of its executors is free: use {advice} and a ReentrantCallbackGroup"


def _text(calls: Sequence[Call], why: str) -> str:
    return f"a deadlock: {', and '.join(map(what_of, calls))}{why}"


def _circle(holders_of: Callable[[Any], Sequence[Call]], first: Call) -> list[Call] | None:
    """Return the calls that wait for each other, beginning with one of them."""
    chain: list[Call] = []
    call: Call | None = first
    while call is not None and call not in chain:
        wait = call.wait
        if wait is None or wait.is_timed or wait.over.is_over:
            return None
        chain.append(call)
        call = _owner(call) or _group_holder(holders_of, call)
    # Another thread may open a lock that this one has taken twice.
    return chain if call is first and _owner(first) is not first else None


def _owner(call: Call) -> Call | None:
    """Return the call that has what another one waits for.

    A condition has a lock that the waiting code has taken itself, and others open.
    """
    modules = [frame.f_globals.get("__name__") for frame in frames_of(call)]
    names = [frame.f_code.co_name for frame in frames_of(call)]
    if ("threading", "wait") in zip(modules, names, strict=True) or call.wait is None:
        return None
    return call.wait.owner()


def _group_holder(holders_of: Callable[[Any], Sequence[Call]], call: Call) -> Call | None:
    """Return the call that keeps the answer from arriving that another one waits for."""
    for frame in frames_of(call):
        key = (frame.f_globals.get("__name__", ""), frame.f_code.co_name)
        client = frame.f_locals.get("self")
        if key in _ANSWERED and isinstance(client, Client | ActionClient):
            holders = holders_of(client.callback_group)
            return next(iter(holders), None)
    return None


def _can_continue(program: Program, calls: Iterable[Call], waiting: Sequence[Call]) -> bool:
    """Return whether code of a program does not only wait for other code of it."""
    for call in waiting:
        if call.wait is None or call.wait.is_timed:
            return True
        if program.handlers and call.life is program.life:
            return True  # a signal continues its main thread
    return any(call.program is program and call not in waiting for call in calls)
