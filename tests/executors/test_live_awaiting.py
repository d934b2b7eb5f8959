"""Callbacks that await something, under the executor of live runs."""

from __future__ import annotations

from collections.abc import Iterator
from types import coroutine

import pytest
from rclpy.task import Future
from std_msgs.msg import Int64

from tests.support.live_rig import LONG_S, Live
from tests.support.two_executors import loose


def test_a_callback_that_awaits_costs_nothing(live: Live) -> None:
    """It has no turn before what it awaits is there, which ends the sleep."""
    gate: Future = Future()
    reports: list[int] = []

    async def wait() -> None:
        reports.append(await gate)

    live.executor.create_task(wait)
    assert not live.executor.serve(0.01)
    turns = live.executor.callbacks_served
    assert not live.executor.serve(0.01)
    assert live.executor.callbacks_served == turns
    gate.set_result(7)
    live.until(lambda: reports)
    assert reports == [7]


def test_what_waits_for_a_held_group_keeps_nobody_up(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A message and a timer of a node whose callback awaits are served when it has ended."""
    gate: Future = Future()
    reports: list[str] = []
    looks: list[None] = []
    node = live.node("a")
    publisher = node.create_publisher(Int64, "count", 10)

    async def wait(_: Int64) -> None:
        await gate
        reports.append("awaited")

    node.create_subscription(Int64, "count", loose(wait), 10)
    node.create_subscription(Int64, "count", lambda _: reports.append("message"), 10)
    is_well = live.context.ok

    def look() -> bool:
        looks.append(None)
        return is_well()

    publisher.publish(Int64())
    assert live.executor.serve(LONG_S)
    node.create_timer(0.001, lambda: reports.append("timer"))
    live.executor.serve(0.01)
    monkeypatch.setattr(live.context, "ok", look)
    assert not live.executor.serve(0.05)
    assert (reports, len(looks) < 10) == ([], True)
    gate.set_result(None)
    live.until(lambda: len(set(reports)) == 3)
    assert reports[0] == "awaited"


def test_a_callback_that_awaits_something_else_gets_its_turns(live: Live) -> None:
    """Nothing tells when it can go on."""
    reports: list[int] = []

    @coroutine
    def turn() -> Iterator[None]:
        yield

    async def take_turns() -> None:
        for number in range(3):
            await turn()
            reports.append(number)

    live.executor.create_task(take_turns)
    live.until(lambda: len(reports) == 3)


def test_a_node_that_has_left_is_not_served(live: Live) -> None:
    """Nor waited for: a callback of it that awaits stays where it is, without keeping anyone up."""
    gate: Future = Future()
    reports: list[str] = []

    async def wait(_: Int64) -> None:
        await gate
        reports.append("went on")

    node = live.node("a")
    publisher = live.node("b").create_publisher(Int64, "count", 10)
    node.create_subscription(Int64, "count", loose(wait), 10)
    publisher.publish(Int64())
    while live.executor.serve(0.01):
        pass
    live.executor.remove_node(node)
    gate.set_result(1)
    while live.executor.serve(0.01):
        pass
    assert reports == []
    live.executor.add_node(node)
    live.until(lambda: reports)
    assert reports == ["went on"]
