"""Every kind of callback is served within its instant, as under rclpy's own executors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from bt_mission_interfaces.action import Turn
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.task import Future
from std_msgs.msg import Int64
from std_srvs.srv import Trigger

S = 1_000_000_000
MS = 1_000_000


def hear(callback: Callable[[Any], None]) -> Any:
    """A subscription's callback; generated messages have no types."""
    return callback


def test_a_chain_of_messages_ends_within_its_instant(rig: Any) -> None:
    """Ten hops over topics take no virtual time."""
    node = rig.node("a")
    ended: list[int] = []

    def hop(number: int) -> None:
        onward = node.create_publisher(Int64, f"hop{number + 1}", 10)
        node.create_subscription(Int64, f"hop{number}", onward.publish, 10)

    for number in range(10):
        hop(number)
    node.create_subscription(Int64, "hop10", lambda m: ended.append(rig.now(node)), 10)
    start = node.create_publisher(Int64, "hop0", 10)

    def begin() -> None:
        timer.cancel()
        start.publish(Int64())

    timer = node.create_timer(0.5, begin)
    rig.executor.step()
    assert ended == [S + 500 * MS]


def test_a_service_call_is_answered_within_the_instant(rig: Any) -> None:
    """A task can await a service of another node."""
    server, client = rig.node("server"), rig.node("client")

    def answer(_: Any, response: Any) -> Any:
        response.message = f"at {rig.now(server)}"
        return response

    server.create_service(Trigger, "ask", answer)
    asking = client.create_client(Trigger, "ask")
    heard: list[str] = []

    async def ask() -> None:
        heard.append((await asking.call_async(Trigger.Request())).message)

    client.create_timer(0.1, lambda: rig.executor.create_task(ask()))
    rig.executor.step()
    assert heard == [f"at {S + 100 * MS}"]


def test_a_coroutine_that_waits_blocks_its_callback_group_and_nothing_else(rig: Any) -> None:
    """While one callback of a node is suspended, its mutually exclusive group waits with it."""
    node, other = rig.node("a"), rig.node("b")
    gate: Future = Future()
    log: list[str] = []

    async def wait_for_gate() -> None:
        slow.cancel()
        log.append("waits")
        await gate
        log.append("goes on")

    slow = node.create_timer(0.1, wait_for_gate)
    node.create_timer(0.1, lambda: log.append("same node"))
    other.create_timer(0.1, lambda: log.append("other node"))
    rig.executor.step()
    assert log == ["waits", "other node"]
    gate.set_result(None)
    rig.executor.run_until_quiet()
    assert log == ["waits", "other node", "goes on"]


def test_tasks_resume_when_what_they_await_is_done(rig: Any) -> None:
    """``create_task`` works as under rclpy's executors, within one instant."""
    gate: Future = Future()

    async def job() -> str:
        await gate
        return "done"

    task = rig.executor.create_task(job())
    rig.executor.run_until_quiet()
    assert not task.done()
    gate.set_result(None)
    rig.executor.run_until_quiet()
    assert task.result() == "done"


def test_an_exception_in_a_callback_comes_out_of_the_step(rig: Any) -> None:
    """Nothing is swallowed: the caller decides what a failing callback means."""

    def fail() -> None:
        raise ZeroDivisionError("in a callback")

    rig.node("a").create_timer(0.1, fail)
    with pytest.raises(ZeroDivisionError, match="in a callback"):
        rig.executor.step()


def test_an_exception_in_a_task_comes_out_of_the_step(rig: Any) -> None:
    """Also from a coroutine that was suspended before."""

    async def fail() -> None:
        raise ZeroDivisionError("in a task")

    rig.executor.create_task(fail())
    with pytest.raises(ZeroDivisionError, match="in a task"):
        rig.executor.run_until_quiet()


def test_entities_made_in_a_callback_are_served_at_once(rig: Any) -> None:
    """A subscription made at one instant hears what is published at the same instant."""
    node = rig.node("a")
    got: list[int] = []
    publisher = node.create_publisher(Int64, "late", 10)

    def make() -> None:
        timer.cancel()
        node.create_subscription(Int64, "late", hear(lambda m: got.append(m.data)), 10)

    timer = node.create_timer(0.1, make)
    node.create_timer(0.1, lambda: publisher.publish(Int64(data=7)))
    rig.executor.step()
    assert got == [7]


def test_a_timer_destroyed_by_an_earlier_one_does_not_fire(rig: Any) -> None:
    """Destruction takes effect within the instant."""
    node = rig.node("a")
    fired: list[str] = []
    node.create_timer(0.1, lambda: node.destroy_timer(doomed))
    doomed: Any = node.create_timer(0.1, lambda: fired.append("doomed"))
    rig.executor.step()
    assert fired == []


def test_a_removed_node_is_served_no_more(rig: Any) -> None:
    """Its timers stop, and the others go on."""
    a, b = rig.node("a"), rig.node("b")
    fired: list[str] = []
    a.create_timer(0.1, lambda: fired.append("a"))
    b.create_timer(0.1, lambda: fired.append("b"))
    rig.executor.step()
    rig.executor.remove_node(a)
    rig.executor.step()
    assert fired == ["a", "b", "b"]


def test_an_action_from_goal_to_result_in_exact_virtual_times(rig: Any) -> None:
    """Accepted, fed, cancelled and ended at the instants at which each thing happened."""
    serving, asking = rig.node("serving"), rig.node("asking")
    log: list[tuple[str, int]] = []
    end: Future = Future()

    async def execute(handle: Any) -> Any:
        await end
        handle.canceled()
        return Turn.Result(angle_turned=12.0)

    def cancel(_: Any) -> CancelResponse:
        log.append(("cancel", rig.now(serving)))
        end.set_result(None)
        return CancelResponse.ACCEPT

    server = ActionServer(serving, Turn, "turn", execute, cancel_callback=cancel)
    client = ActionClient(asking, Turn, "turn")

    async def story() -> None:
        timer.cancel()
        handle = await client.send_goal_async(Turn.Goal(angle=90.0))
        log.append(("accepted", rig.now(asking)))
        later: Any = asking.create_timer(1.0, lambda: (later.cancel(), handle.cancel_goal_async()))
        result = await handle.get_result_async()
        log.append((f"status {result.status}, {result.result.angle_turned}", rig.now(asking)))

    def begin() -> None:
        timer.cancel()
        rig.executor.create_task(story())

    timer = asking.create_timer(0.5, begin)
    asking.create_timer(1.0, lambda: None)
    rig.steps_until(S + 2 * S)
    assert log == [
        ("accepted", S + 500 * MS),
        ("cancel", S + 1500 * MS),
        ("status 5, 12.0", S + 1500 * MS),
    ]
    client.destroy()
    server.destroy()


def test_a_task_that_raises_does_not_take_the_others_with_it(rig: Any) -> None:
    """Tasks before and after it in the queue go on, and so do suspended callbacks."""
    gate: Future = Future()
    log: list[str] = []

    async def wait(name: str) -> None:
        await gate
        log.append(name)

    async def fail() -> None:
        raise ZeroDivisionError("in a task")

    node = rig.node("a")

    async def once() -> None:
        timer.cancel()
        await wait("callback")

    timer: Any = node.create_timer(0.1, once)
    rig.executor.step()
    rig.executor.create_task(wait("before"))
    rig.executor.create_task(fail())
    rig.executor.create_task(wait("after"))
    with pytest.raises(ZeroDivisionError):
        rig.executor.run_until_quiet()
    gate.set_result(None)
    rig.executor.run_until_quiet()
    assert sorted(log) == ["after", "before", "callback"]


def test_a_suspended_callback_that_raises_frees_its_callback_group(rig: Any) -> None:
    """The node's other callbacks are served again."""
    node = rig.node("a")
    gate: Future = Future()
    fired: list[str] = []

    async def fail_later() -> None:
        failing.cancel()
        await gate
        raise ZeroDivisionError("after waiting")

    failing: Any = node.create_timer(0.1, fail_later)
    node.create_timer(0.1, lambda: fired.append("other"))
    rig.executor.step()
    assert fired == []
    gate.set_result(None)
    with pytest.raises(ZeroDivisionError, match="after waiting"):
        rig.executor.run_until_quiet()
    rig.executor.step()
    assert fired == ["other"]


def test_results_that_expire_do_not_stop_time(rig: Any) -> None:
    """At the instant at which a result is exactly as old as it may be, it stays due in rcl."""
    serving, asking = rig.node("serving"), rig.node("asking")

    async def execute(handle: Any) -> Any:
        handle.succeed()
        return Turn.Result()

    server = ActionServer(serving, Turn, "turn", execute, result_timeout=3)
    client = ActionClient(asking, Turn, "turn")
    ended: list[int] = []

    async def ask() -> None:
        handle = await client.send_goal_async(Turn.Goal())
        ended.append((await handle.get_result_async()).status)

    asking.create_timer(1.0, lambda: rig.executor.create_task(ask()))
    rig.steps_until(9 * S)
    assert ended == [4] * 8
    client.destroy()
    server.destroy()


def test_time_goes_on_while_a_callback_holds_its_group(rig: Any) -> None:
    """The node's own timers wait for it, those of others do not; afterwards it catches up."""
    node, other = rig.node("a"), rig.node("b")
    gate: Future = Future()
    fired: list[tuple[str, int]] = []

    async def hold() -> None:
        holding.cancel()
        await gate

    holding: Any = node.create_timer(0.1, hold)
    node.create_timer(0.2, lambda: fired.append(("held", rig.now(node))))
    other.create_timer(0.3, lambda: fired.append(("free", rig.now(other))))
    rig.steps_until(S + 700 * MS)
    assert fired == [("free", S + 300 * MS), ("free", S + 600 * MS)]
    gate.set_result(None)
    rig.executor.run_until_quiet()
    rig.executor.step()
    assert fired[2:] == [("held", S + 600 * MS)]
