"""What callback groups keep apart."""

from __future__ import annotations

from functools import partial
from typing import Any

from rclpy.callback_groups import (
    CallbackGroup,
    MutuallyExclusiveCallbackGroup,
    ReentrantCallbackGroup,
)
from rclpy.task import Future
from std_msgs.msg import Int64
from std_srvs.srv import Trigger

from tests.support.two_executors import Play, loose


def an_exclusive_group_is_held_by_a_coroutine_that_waits(play: Play) -> None:
    _everything_beside_a_callback_that_waits(play, MutuallyExclusiveCallbackGroup())


def a_reentrant_group_is_not(play: Play) -> None:
    _everything_beside_a_callback_that_waits(play, ReentrantCallbackGroup())


def _everything_beside_a_callback_that_waits(play: Play, group: CallbackGroup) -> None:
    node, other = play.node("a"), play.node("b")
    gate: Future = Future()

    async def hold() -> None:
        holding.cancel()
        play.say("holder", "waits")
        await gate
        play.say("holder", f"ends at {play.ms(node)}")

    def answer(_: Any, response: Any) -> Any:
        play.say("service", play.ms(node))
        return response

    holding = node.create_timer(0.1, hold, callback_group=group)
    node.create_timer(0.2, lambda: play.say("timer", play.ms(node)), callback_group=group)
    node.create_subscription(
        Int64, "count", lambda m: play.say("topic", play.ms(node)), 10, callback_group=group
    )
    node.create_service(Trigger, "ask", answer, callback_group=group)
    node.create_timer(0.2, lambda: play.say("own group", play.ms(node)))
    publisher = other.create_publisher(Int64, "count", 10)
    client = other.create_client(Trigger, "ask")

    def ask() -> None:
        publisher.publish(Int64())
        client.call_async(Trigger.Request()).add_done_callback(
            lambda _: play.say("client", play.ms(other))
        )

    other.create_timer(0.25, ask)
    play.advance(0.6)
    play.release(gate)
    play.advance(0.3)


def two_exclusive_groups_do_not_hold_each_other(play: Play) -> None:
    node = play.node("a")
    gate: Future = Future()

    async def wait(name: str) -> None:
        play.say(name, f"waits at {play.ms(node)}")
        await gate
        play.say(name, f"ends at {play.ms(node)}")

    for name in ("one", "two"):
        callback = partial(wait, name)
        node.create_timer(0.1, callback, callback_group=MutuallyExclusiveCallbackGroup())
    play.advance(0.25)
    play.release(gate)


def a_group_over_two_nodes(play: Play) -> None:
    group = MutuallyExclusiveCallbackGroup()
    a, b = play.node("a"), play.node("b")
    gate: Future = Future()

    async def hold() -> None:
        play.say("a", f"waits at {play.ms(a)}")
        await gate
        play.say("a", f"ends at {play.ms(a)}")

    a.create_timer(0.1, hold, callback_group=group)
    b.create_timer(0.15, lambda: play.say("b", play.ms(b)), callback_group=group)
    play.advance(0.35)
    play.release(gate)


def a_group_is_passed_on_when_a_callback_ends(play: Play) -> None:
    node = play.node("a")
    group = MutuallyExclusiveCallbackGroup()
    gates = {"one": Future(), "two": Future()}
    publishers = {}

    def listen(name: str) -> None:
        async def hear(_: Any) -> None:
            play.say("group", f"{name} begins")
            await gates[name]
            play.say("group", f"{name} ends")

        node.create_subscription(Int64, name, loose(hear), 10, callback_group=group)
        publishers[name] = node.create_publisher(Int64, name, 10)

    for name in gates:
        listen(name)
        publishers[name].publish(Int64())
    play.settle()
    for name, gate in gates.items():
        play.say("group", f"{name} may end")
        play.release(gate)
