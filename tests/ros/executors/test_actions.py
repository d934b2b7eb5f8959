"""Actions that our executor of virtual time serves."""

from __future__ import annotations

from typing import Any

from bt_mission_interfaces.action import Turn
from rclpy.action import ActionClient, ActionServer


def test_an_action_of_a_node_that_is_served_is_offered(rig: Any) -> None:
    """It is known without asking the graph; a change is not known at once."""
    node = rig.node("server")
    server = ActionServer(node, Turn, "turn", lambda _: Turn.Result())
    assert not rig.clock.offers("/turn")
    rig.clock.run_until_quiet()
    names = ("/turn", "turn", "/spin")
    assert [name for name in names if rig.clock.offers(name)] == ["/turn"]
    server.destroy()
    assert not rig.clock.offers("/turn")
    rig.clock.run_until_quiet()
    assert not rig.clock.offers("/turn")
    ActionServer(node, Turn, "turn", lambda _: Turn.Result())
    rig.clock.run_until_quiet()
    rig.clock.remove_node(node)
    rig.clock.run_until_quiet()
    assert not rig.clock.offers("/turn")


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
    rig.steps_until(9_000_000_000)
    assert ended == [4] * 8
    client.destroy()
    server.destroy()
