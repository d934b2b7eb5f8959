"""The executor of live runs sleeps until there is something to serve."""

from __future__ import annotations

from contextlib import ExitStack, closing
from typing import Any

import pytest
from bt_mission_interfaces.action import Turn
from rclpy.action import ActionClient, ActionServer
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.task import Future
from rosgraph_msgs.msg import Clock as ClockMessage
from std_msgs.msg import Int64

from bt_mission.base.dds.discovery import MACHINE, RANGE
from bt_mission.ros.executors import arrivals as module
from bt_mission.ros.executors.arrivals import Arrivals
from tests.support.live_rig import LONG_S, Live, count_of, value_of
from tests.support.two_executors import loose


def numbers_of(node: Node, qos: int | QoSProfile = 10) -> list[int]:
    """Subscribe to ``count``; gives the numbers that have come."""
    numbers: list[int] = []
    node.create_subscription(Int64, "count", lambda message: numbers.append(value_of(message)), qos)
    return numbers


def test_nothing_to_serve_is_told_after_the_time_that_was_given(live: Live) -> None:
    """With an entity that was sent nothing, and without any."""
    assert not live.executor.serve(0.01)
    live.node("a").create_subscription(Int64, "count", lambda _: None, 10)
    while live.executor.serve(0.01):
        pass
    assert not live.executor.serve(0.0)


def test_a_message_from_another_context_ends_the_sleep(monkeypatch: pytest.MonkeyPatch) -> None:
    """As one from another process does: a thread of the middleware tells of it."""
    monkeypatch.setenv(RANGE, MACHINE)
    with ExitStack() as stack:
        first, other = stack.enter_context(closing(Live())), stack.enter_context(closing(Live()))
        messages = numbers_of(first.node("a"))
        publisher = other.node("b").create_publisher(Int64, "count", 10)
        while not publisher.get_subscription_count():
            first.executor.serve(0.01)
        publisher.publish(Int64(data=3))
        first.until(lambda: messages)
    assert messages == [3]


def test_timers_of_the_wall_end_the_sleep(live: Live) -> None:
    """Whoever waits for them without an end is served at each."""
    fired: list[int] = []
    wall = Clock(clock_type=ClockType.STEADY_TIME)
    live.node("a").create_timer(0.001, lambda: fired.append(0), clock=wall)
    while len(fired) < 3:
        live.executor.spin_once()


def test_a_timer_of_simulated_time_waits_for_the_clock(live: Live) -> None:
    """However long that takes; and the clock ends the sleep, also where it is used from now on."""
    fired: list[int] = []
    node = live.node("a")
    node.create_timer(0.001, lambda: fired.append(node.get_clock().now().nanoseconds))
    live.until(lambda: fired)
    node.set_parameters([Parameter("use_sim_time", value=True)])
    publisher = live.node("b").create_publisher(ClockMessage, "/clock", 1)
    fired.clear()
    while live.executor.serve(0.01):
        pass
    assert fired == []
    message = ClockMessage()
    for seconds in (5, 6):  # from the first on the timer is due, a period later
        message.clock.sec = seconds
        publisher.publish(message)
        assert live.executor.serve(LONG_S)
    live.until(lambda: fired)
    assert fired == [6_000_000_000]


def test_a_flood_on_one_topic_holds_nobody_up(live: Live) -> None:
    """Each round serves a message of it, and everything else that is ready."""
    order: list[str] = []
    node = live.node("a")
    flood = node.create_publisher(Int64, "flood", 1000)
    drop = node.create_publisher(Int64, "drop", 10)
    node.create_subscription(Int64, "flood", lambda _: order.append("flood"), 1000)
    node.create_subscription(Int64, "drop", lambda _: order.append("drop"), 10)
    for _ in range(500):
        flood.publish(Int64())
    drop.publish(Int64())
    live.until(lambda: "drop" in order)
    assert order == ["flood", "drop"]
    live.until(lambda: len(order) == 501)
    assert not live.executor.serve(0.0)


def test_what_a_queue_has_dropped_is_not_looked_for(live: Live) -> None:
    """A thousand came, one is there: two rounds, and the executor sleeps again."""
    node = live.node("a")
    publisher = node.create_publisher(Int64, "count", 10)
    messages = numbers_of(node, QoSProfile(depth=1))
    while live.executor.serve(0.0):
        pass
    for number in range(1000):
        publisher.publish(Int64(data=number))
    rounds = 0
    while live.executor.serve(0.0):
        rounds += 1
    assert (messages, rounds) == ([999], 2)


def test_a_future_ends_the_spin(live: Live) -> None:
    """As it does under rclpy's own."""
    done: Future = Future()
    wall = Clock(clock_type=ClockType.STEADY_TIME)
    live.node("a").create_timer(0.001, lambda: done.set_result(1), clock=wall)
    live.executor.spin_until_future_complete(done)
    live.executor.spin_until_future_complete(Future(), timeout_sec=0.01)
    live.executor.spin_once_until_future_complete(done, timeout_sec=LONG_S)
    assert done.result() == 1


def test_results_are_dropped_when_they_expire(live: Live) -> None:
    """Also where nothing more is asked: their time ends the sleep."""

    async def execute(handle: Any) -> Any:
        handle.succeed()
        return Turn.Result()

    server = ActionServer(live.node("a"), Turn, "turn", loose(execute), result_timeout=0.05)
    client = ActionClient(live.node("b"), Turn, "turn")
    sent = client.send_goal_async(Turn.Goal())
    live.until(sent.done)
    result = sent.result().get_result_async()
    live.until(result.done)
    assert len(server._goal_handles) == 1
    live.until(lambda: not server._goal_handles)
    assert not server._result_futures
    assert not live.executor.serve(0.01)
    unknown = sent.result().get_result_async()
    live.until(unknown.done)
    assert (result.result().status, unknown.result().status) == (4, 0)


def test_events_of_discovery_are_served(live: Live) -> None:
    """Once each: a publisher whose messages cannot be taken is told of."""
    reports: list[int] = []
    events = SubscriptionEventCallbacks(
        incompatible_qos=lambda event: reports.append(count_of(event))
    )
    node = live.node("a")
    node.create_subscription(Int64, "count", lambda _: None, 10, event_callbacks=events)
    best = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    node.create_publisher(Int64, "count", best)
    live.until(lambda: reports)
    while live.executor.serve(0.01):
        pass
    assert reports == [1]


def test_what_the_middleware_does_not_tell_of_is_asked_for(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Under one that has no such functions, all is."""
    monkeypatch.setattr(Arrivals, "_link", lambda *_: None)
    node = live.node("a")
    publisher = node.create_publisher(Int64, "count", 10)
    messages = numbers_of(node)
    assert not live.executor.serve(0.0)
    publisher.publish(Int64(data=2))
    live.until(lambda: messages)
    assert messages == [2]


def test_files_that_others_need_are_left_to_them(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whoever gets none is asked, and those that have one go on to be told of."""
    messages: list[str] = []
    node = live.node("a")
    publisher = node.create_publisher(Int64, "count", 10)
    node.create_subscription(Int64, "count", lambda _: messages.append("told"), 10)
    live.executor.serve(0.0)
    monkeypatch.setattr(module, "_most_files", lambda: 0)
    node.create_subscription(Int64, "count", lambda _: messages.append("asked"), 10)
    live.executor.serve(0.0)
    publisher.publish(Int64())
    live.until(lambda: len(messages) == 2)
    assert messages == ["told", "asked"]


def test_a_context_that_is_shut_down_ends_it(live: Live) -> None:
    """As rclpy's own executors say; an executor that is shut down returns at once."""
    live.node("a")
    live.executor.serve(0.0)
    live.context.shutdown()
    with pytest.raises(ExternalShutdownException):
        live.executor.serve()
    live.executor.shutdown()
    assert not live.executor.serve()
    live.executor.spin()


# ---- callbacks that await something ---------------------------------------------------------


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
