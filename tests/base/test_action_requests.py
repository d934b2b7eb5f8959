"""Requests to an action server are answered several in a row."""

from __future__ import annotations

from collections.abc import Coroutine
from typing import Any

from bt_mission.base.action_requests import BURST, BoundedRequests


class FakeServer:
    """Has requests that wait, as rclpy's action server has."""

    def __init__(self, **waiting: int) -> None:
        self.waiting = waiting
        self.answered: list[str] = []
        self._is_goal_request_ready = self._is_cancel_request_ready = False
        self._is_result_request_ready = self._is_goal_expired = False

    def take_data(self) -> dict[str, Any]:
        """Take one of each kind that is said to be ready."""
        ready = {"goal": self._is_goal_request_ready, "cancel": self._is_cancel_request_ready}
        taken = [kind for kind, is_ready in ready.items() if is_ready and self.waiting.get(kind)]
        for kind in taken:
            self.waiting[kind] -= 1
        return dict.fromkeys(taken, ("header", "request"))

    async def execute(self, taken: dict[str, Any]) -> None:
        """Answer."""
        self.answered += taken


class Server(BoundedRequests, FakeServer):
    """With bounds."""


def run(work: Coroutine[Any, Any, None]) -> None:
    """Run what never waits."""
    try:
        work.send(None)
    except StopIteration:
        return
    raise AssertionError("it waits")


def test_so_many_are_answered_in_a_row() -> None:
    """Then whatever else is ready has its turn."""
    server = Server(burst=BURST, goal=100)
    run(server.execute({"goal": ("header", "request")}))
    assert server.answered == ["goal"] * BURST
    assert server.waiting["goal"] == 100 - (BURST - 1)


def test_what_was_not_ready_is_not_asked_for() -> None:
    """The executor has not found it so."""
    server = Server(burst=BURST, goal=1, cancel=5)
    run(server.execute({"goal": ("header", "request")}))
    assert server.answered == ["goal", "goal"]
    assert server.waiting["cancel"] == 5


def test_one_by_one_unless_a_burst_is_asked_for() -> None:
    """So that each can be tapped on a stage."""
    server = Server(goal=5)
    run(server.execute({"goal": ("header", "request")}))
    assert server.answered == ["goal"]
