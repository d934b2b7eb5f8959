"""Every kind of callback is served within its instant, as under rclpy's own executors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bt_mission_interfaces.action import Turn
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.task import Future

S = 1_000_000_000
MS = 1_000_000


def hear(callback: Callable[[Any], None]) -> Any:
    """A subscription's callback; generated messages have no types."""
    return callback


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

    async def act() -> None:
        timer.cancel()
        handle = await client.send_goal_async(Turn.Goal(angle=90.0))
        log.append(("accepted", rig.now(asking)))
        later: Any = asking.create_timer(1.0, lambda: (later.cancel(), handle.cancel_goal_async()))
        result = await handle.get_result_async()
        log.append((f"status {result.status}, {result.result.angle_turned}", rig.now(asking)))

    def begin() -> None:
        timer.cancel()
        rig.clock.create_task(act())

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

    asking.create_timer(1.0, lambda: rig.clock.create_task(ask()))
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
    rig.clock.run_until_quiet()
    rig.clock.step()
    assert fired[2:] == [("held", S + 600 * MS)]
