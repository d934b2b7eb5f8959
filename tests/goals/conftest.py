"""A server that a test plays move by move."""

from __future__ import annotations

from typing import Any

import pytest

from bt_mission.goals.goal import Event, Goal


class ScriptedServer:
    """A courier whose server answers when the test says so."""

    def __init__(self, name: str = "/turn", *, ready: bool = True) -> None:
        self.name = name
        self.ready = ready
        self.goals: list[Goal] = []
        self.requests: list[Any] = []
        self.results_asked: list[Goal] = []
        self.cancels: list[Goal] = []

    def is_ready(self) -> bool:
        return self.ready

    def send(self, goal: Goal, request: Any) -> None:
        self.goals.append(goal)
        self.requests.append(request)

    def ask_result(self, goal: Goal) -> None:
        self.results_asked.append(goal)

    def send_cancel(self, goal: Goal) -> None:
        self.cancels.append(goal)

    # the moves

    @property
    def goal(self) -> Goal:
        return self.goals[-1]

    def accept(self) -> None:
        self.goal.on(Event.ACCEPTED)

    def reject(self) -> None:
        self.goal.on(Event.REJECTED)

    def feed(self, feedback: Any) -> None:
        self.goal.on_feedback(feedback)

    def refuse_cancel(self) -> None:
        self.goal.on(Event.CANCEL_REFUSED)

    def succeed(self, result: Any = "result") -> None:
        self.goal.on_result(4, result)

    def cancel(self, result: Any = "partial") -> None:
        self.goal.on_result(5, result)

    def abort(self, result: Any = None) -> None:
        self.goal.on_result(6, result)


@pytest.fixture
def server() -> ScriptedServer:
    """A server at ``/turn`` that the test plays."""
    return ScriptedServer()
