"""What services and their clients do."""

from __future__ import annotations

from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.client import Client
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import SetBool, Trigger

from tests.support.two_executors import Play


def _offer(play: Play, node: Node, name: str = "ask") -> Any:
    count = [0]

    def answer(_: Any, response: Any) -> Any:
        count[0] += 1
        response.message = f"{name} {count[0]}"
        play.say(name, f"call {count[0]} at {play.ms(node)}")
        return response

    return node.create_service(Trigger, name, answer)


def _call(play: Play) -> tuple[Client, Future]:
    client = play.node("client").create_client(Trigger, "ask")
    return client, client.call_async(Trigger.Request())


def a_call_from_a_timer_is_answered(play: Play) -> None:
    _offer(play, play.node("server"))
    node = play.node("client")
    client = node.create_client(Trigger, "ask")

    def call() -> None:
        future = client.call_async(Trigger.Request())
        future.add_done_callback(lambda f: play.say("client", (f.result().message, play.ms(node))))

    node.create_timer(0.1, call)
    play.advance(0.35)


def an_async_callback_awaits_a_service_of_another_node(play: Play) -> None:
    _offer(play, play.node("server"))
    node = play.node("client")
    client = node.create_client(Trigger, "ask")

    async def call() -> None:
        play.say("client", "calls")
        answer = await client.call_async(Trigger.Request())
        play.say("client", answer.message)

    node.create_timer(0.1, call, callback_group=ReentrantCallbackGroup())
    play.advance(0.25)


def a_callback_that_awaits_a_client_of_its_own_exclusive_group_waits_for_ever(play: Play) -> None:
    _offer(play, play.node("server"))
    node = play.node("client")
    client = node.create_client(Trigger, "ask")

    async def call() -> None:
        play.say("client", "calls")
        await client.call_async(Trigger.Request())
        play.say("client", "never")

    node.create_timer(0.1, call)
    play.advance(0.5)


def an_async_handler_awaits_another_service(play: Play) -> None:
    _offer(play, play.node("inner"), "inner")
    middle = play.node("middle")
    inward = middle.create_client(Trigger, "inner", callback_group=ReentrantCallbackGroup())

    async def answer(_: Any, response: Any) -> Any:
        play.say("middle", "asks on")
        response.message = f"by {(await inward.call_async(Trigger.Request())).message}"
        return response

    middle.create_service(Trigger, "outer", answer)
    node = play.node("client")
    client = node.create_client(Trigger, "outer")
    for _ in range(3):
        client.call_async(Trigger.Request()).add_done_callback(
            lambda f: play.say("client", f.result().message)
        )
    play.settle()


def two_clients_get_their_own_answers(play: Play) -> None:
    def answer(request: Any, response: Any) -> Any:
        response.message = f"you said {request.data}"
        return response

    play.node("server").create_service(SetBool, "ask", answer)
    for data in (True, False):
        client = play.node(f"client_{data}".lower()).create_client(SetBool, "ask")
        for _ in range(2):
            future = client.call_async(SetBool.Request(data=data))
            future.add_done_callback(lambda f, d=data: play.say(str(d), f.result().message))
    play.settle()


def a_handler_that_raises_leaves_its_call_and_no_other_without_an_answer(play: Play) -> None:
    count = [0]

    def answer(_: Any, response: Any) -> Any:
        count[0] += 1
        if count[0] == 1:
            raise ValueError("in a service")
        return response

    play.node("server").create_service(Trigger, "ask", answer)
    client = play.node("client").create_client(Trigger, "ask")
    calls = [client.call_async(Trigger.Request()) for _ in range(2)]
    play.settle()
    play.say("client", [call.done() for call in calls])


def an_async_handler_that_raises_after_waiting(play: Play) -> None:
    gate: Future = Future()

    async def answer(_: Any, response: Any) -> Any:
        await gate
        raise ValueError("after waiting")

    play.node("server").create_service(Trigger, "ask", answer)
    _, call = _call(play)
    play.settle()
    gate.set_result(None)
    play.settle()
    play.say("client", call.done())


def an_answer_of_the_wrong_type(play: Play) -> None:
    play.node("server").create_service(Trigger, "ask", lambda *_: "no response")
    _, call = _call(play)
    play.settle()
    play.say("client", call.done())


def a_call_that_is_cancelled_gets_no_answer(play: Play) -> None:
    _offer(play, play.node("server"))
    _, call = _call(play)
    call.add_done_callback(lambda f: play.say("client", f"done: {f.cancelled()} {f.result()}"))
    call.cancel()
    play.settle()


def a_request_that_is_forgotten_gets_no_answer(play: Play) -> None:
    _offer(play, play.node("server"))
    client, call = _call(play)
    client.remove_pending_request(call)
    play.settle()
    play.say("client", call.done())


def a_client_destroyed_before_its_answer(play: Play) -> None:
    _offer(play, play.node("server"))
    client, call = _call(play)
    play.nodes[-1].destroy_client(client)
    play.settle()
    play.say("client", call.done())


def a_service_destroyed_before_it_is_asked(play: Play) -> None:
    server = play.node("server")
    service = _offer(play, server)
    client, call = _call(play)
    server.destroy_service(service)
    play.settle()
    play.say("client", (call.done(), client.service_is_ready()))


def a_service_made_later_does_not_hear_earlier_calls(play: Play) -> None:
    client, early = _call(play)
    play.settle()
    _offer(play, play.node("server"))
    play.wait_for(client.service_is_ready)
    late = client.call_async(Trigger.Request())
    play.settle()
    play.say("client", (early.done(), late.done()))


def a_call_from_the_answer_of_a_call(play: Play) -> None:
    _offer(play, play.node("server"))
    client = play.node("client").create_client(Trigger, "ask")

    def again(future: Future) -> None:
        message = future.result().message
        play.say("client", message)
        if not message.endswith("3"):
            client.call_async(Trigger.Request()).add_done_callback(again)

    client.call_async(Trigger.Request()).add_done_callback(again)
    play.settle()


def a_service_of_ones_own_node(play: Play) -> None:
    node = play.node("a")
    _offer(play, node)
    client = node.create_client(Trigger, "ask")
    call = client.call_async(Trigger.Request())
    play.settle()
    play.say("client", call.result().message)
