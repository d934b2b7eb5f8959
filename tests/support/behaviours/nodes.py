"""What nodes do that come, go, and are destroyed."""

from __future__ import annotations

from typing import Any

from bt_mission_interfaces.action import Turn
from rclpy.action import ActionClient, ActionServer
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import Int64
from std_srvs.srv import Trigger

from tests.support.two_executors import Play


def a_node_destroyed_in_its_own_callback(play: Play) -> None:
    node, other = play.node("a"), play.node("b")
    node.create_subscription(Int64, "count", play.hear("a"), 10)
    node.create_service(Trigger, "ask", lambda _, response: response)
    publisher = other.create_publisher(Int64, "count", 10)
    number = [0]

    def publish() -> None:
        number[0] += 1
        publisher.publish(Int64(data=number[0]))

    def leave() -> None:
        play.say("a", "leaves")
        node.destroy_node()

    other.create_timer(0.1, publish)
    node.create_timer(0.25, leave)
    play.advance(0.5)
    play.say("b", publisher.get_subscription_count())


def a_node_destroyed_by_another(play: Play) -> None:
    node, other = play.node("a"), play.node("b")
    node.create_timer(0.1, lambda: play.say("a", play.ms(node)))

    def destroy() -> None:
        destroying.cancel()
        node.destroy_node()

    destroying = other.create_timer(0.25, destroy)
    other.create_timer(0.1, lambda: play.say("b", play.ms(other)))
    play.advance(0.5)


def a_node_destroyed_while_a_message_and_a_call_wait_for_it(play: Play) -> None:
    node, other = play.node("a"), play.node("b")
    node.create_subscription(Int64, "count", play.hear("a"), 10)
    node.create_service(Trigger, "ask", lambda _, response: response)
    publisher = other.create_publisher(Int64, "count", 10)
    client = other.create_client(Trigger, "ask")
    publisher.publish(Int64())
    call = client.call_async(Trigger.Request())
    node.destroy_node()
    play.advance(0.2)
    play.say("b", (publisher.get_subscription_count(), call.done()))


def a_node_destroyed_with_its_actions(play: Play) -> None:
    node, other = play.node("a"), play.node("b")
    server = ActionServer(node, Turn, "turn", lambda handle: Turn.Result())
    client = ActionClient(other, Turn, "turn")
    play.settle()

    def leave() -> None:
        leaving.cancel()
        play.say("a", "leaves")
        server.destroy()
        node.destroy_node()

    leaving = node.create_timer(0.1, leave)
    play.advance(0.3)
    play.wait_for(lambda: not client.server_is_ready())
    other.create_timer(0.1, lambda: play.say("b", play.ms(other)))
    play.advance(0.25)


def a_subscription_destroyed_by_the_one_before_it(play: Play) -> None:
    node = play.node("a")

    def hear(message: Any) -> None:
        play.say("a", f"first {message.data}")
        node.destroy_subscription(doomed)

    node.create_subscription(Int64, "count", hear, 10)
    doomed = node.create_subscription(Int64, "count", play.hear("a"), 10)
    node.create_publisher(Int64, "count", 10).publish(Int64(data=1))
    play.settle()


def a_service_and_a_client_destroyed_by_a_message(play: Play) -> None:
    node = play.node("a")

    def answer(_: Any, response: Any) -> Any:
        play.say("service", "asked")
        return response

    service = node.create_service(Trigger, "ask", answer)
    client = node.create_client(Trigger, "ask")

    def hear(_: Any) -> None:
        play.say("a", "destroys")
        node.destroy_service(service)
        node.destroy_client(client)

    publish = play.pipe(node, hear)
    call = client.call_async(Trigger.Request())
    publish(0)
    play.settle()
    play.say("a", call.done())


def a_removed_node_is_not_served(play: Play) -> None:
    node, other = play.node("a"), play.node("b")
    node.create_subscription(Int64, "count", play.hear("a"), 10)
    publisher = other.create_publisher(Int64, "count", 10)
    publisher.publish(Int64(data=1))
    play.settle()
    play.executor.remove_node(node)
    publisher.publish(Int64(data=2))
    play.settle()
    play.say("a", f"served by {[served.get_name() for served in play.executor.get_nodes()]}")


def what_came_while_a_node_was_away_is_served_when_it_is_back(play: Play) -> None:
    node, other = play.node("a"), play.node("b")
    node.create_subscription(Int64, "count", play.hear("a"), 2)
    node.create_service(Trigger, "ask", lambda _, response: response)
    publisher = other.create_publisher(Int64, "count", 10)
    client = other.create_client(Trigger, "ask")
    play.executor.remove_node(node)
    for number in range(4):
        publisher.publish(Int64(data=number))
    call = client.call_async(Trigger.Request())
    play.settle()
    play.say("a", f"back, {call.done()}")
    play.executor.add_node(node)
    play.settle()
    play.say("client", call.done())


def _suspended(play: Play) -> tuple[Node, Future]:
    """Return a node whose callback waits, and for what it waits."""
    node = play.node("a")
    gate: Future = Future()

    async def wait(_: Any) -> None:
        play.say("a", "waits")
        await gate
        play.say("a", "goes on")

    play.pipe(node, wait)(0)
    play.settle()
    return node, gate


def a_suspended_callback_of_a_removed_node_waits_for_its_return(play: Play) -> None:
    node, gate = _suspended(play)
    play.executor.remove_node(node)
    play.release(gate)
    play.say("a", "back")
    play.executor.add_node(node)
    play.settle()


def a_suspended_callback_of_a_destroyed_node_goes_on(play: Play) -> None:
    node, gate = _suspended(play)
    node.destroy_node()
    play.settle()
    play.release(gate)


def a_task_goes_on_without_the_node_that_made_it(play: Play) -> None:
    node = play.node("a")
    gate: Future = Future()

    async def job() -> None:
        await gate
        play.say("task", "ends")

    node.create_timer(0.1, lambda: play.executor.create_task(job()))
    play.advance(0.1)
    play.executor.remove_node(node)
    play.release(gate)


def a_node_is_added_once(play: Play) -> None:
    node = play.node("a", served=False)
    play.say("a", node.executor is None)
    play.say("a", [play.executor.add_node(node) for _ in range(2)])
    play.say("a", (node.executor is play.executor, len(play.executor.get_nodes())))
    node.create_timer(0.1, lambda: play.say("a", play.ms(node)))
    play.advance(0.25)


def a_node_is_removed_twice(play: Play) -> None:
    node = play.node("a")
    play.executor.remove_node(node)
    play.executor.remove_node(node)
    play.say("a", play.executor.get_nodes())


def a_node_that_is_given_to_another_executor(play: Play) -> None:
    node = play.node("a")
    node.create_timer(0.1, lambda: play.say("a", play.ms(node)))
    play.advance(0.15)
    other = type(play.executor)(context=play.context)
    other.add_node(node)
    play.say("a", (play.executor.get_nodes(), len(other.get_nodes())))
    play.advance(0.3)
    other.shutdown()


def what_waits_for_a_node_is_served_by_its_next_executor(play: Play) -> None:
    node, other = play.node("a"), play.node("b")
    second = type(play.executor)(context=play.context)
    last: Future = Future()

    def hear(message: Any) -> None:
        play.say("a", message.data)
        second.add_node(node)
        if message.data == 2:
            last.set_result(None)

    node.create_service(Trigger, "ask", lambda _, response: response)
    asked = other.create_client(Trigger, "ask").call_async(Trigger.Request())
    publish = play.pipe(node, hear)
    publish(0, 1, 2)
    play.settle()
    second.spin_until_future_complete(last, timeout_sec=5)
    second.shutdown()
    play.settle()
    play.say("client", asked.done())


def a_node_that_has_an_executor_for_each_message(play: Play) -> None:
    node = play.node("a")
    play.executor.remove_node(node)
    gates: list[Future] = []

    def hear(message: Any) -> None:
        play.say("a", message.data)
        gates[-1].set_result(None)

    publish = play.pipe(node, hear)
    for number in range(4):
        gates.append(Future())
        executor = type(play.executor)(context=play.context)
        executor.add_node(node)
        publish(number)
        executor.spin_until_future_complete(gates[-1], timeout_sec=5)
        executor.remove_node(node)


def a_node_that_is_taken_from_its_executor(play: Play) -> None:
    node = play.node("a")
    node.executor = None  # type: ignore[assignment]  # rclpy allows it
    play.say("a", (play.executor.get_nodes(), node.executor))


def a_node_made_in_a_callback(play: Play) -> None:
    node = play.node("a")

    def make() -> None:
        making.cancel()
        late = play.node("late")
        late.create_timer(0.1, lambda: play.say("late", play.ms(late)))

    making = node.create_timer(0.1, make)
    play.advance(0.4)


def an_executor_that_is_shut_down_has_no_nodes(play: Play) -> None:
    play.node("a")
    play.say("a", play.executor.shutdown())
    play.say("a", (play.executor.get_nodes(), play.executor.shutdown()))


def an_executor_spins_until_a_future_is_done(play: Play) -> None:
    node = play.node("a")
    gate: Future = Future()
    play.pipe(node, lambda m: gate.set_result(m.data))(5)
    play.executor.spin_until_future_complete(gate)
    play.say("a", gate.result())
    play.executor.spin_until_future_complete(gate)
    play.say("a", "at once")


def an_executor_spins_until_the_context_ends(play: Play) -> None:
    node = play.node("a")

    def end(_: Any) -> None:
        play.say("a", "ends it")
        play.context.shutdown()

    play.pipe(node, end)(0)
    try:
        play.executor.spin()
    except Exception as error:
        play.say("executor", type(error).__name__)
        raise
    play.say("executor", "returns")


def an_executor_does_not_spin_where_the_context_has_ended(play: Play) -> None:
    play.node("a").create_guard_condition(lambda: None)
    play.settle()
    play.context.shutdown()
    play.executor.spin()
    play.say("executor", "returns")
    try:
        play.executor.spin_once(timeout_sec=0)
    except Exception:  # noqa: BLE001 - rclpy's is an RCLError by chance, ours says what it is
        play.say("executor", "raises")


def an_executor_that_is_shut_down_spins_no_more(play: Play) -> None:
    node = play.node("a")
    play.pipe(node, play.hear("a"))(0)
    play.executor.shutdown()
    play.executor.spin()
    play.executor.spin_once(timeout_sec=0)
    play.say("executor", "returns")


def an_executor_spins_until_it_is_shut_down(play: Play) -> None:
    node = play.node("a")

    def end(_: Any) -> None:
        play.say("a", "ends it")
        play.executor.shutdown()

    play.pipe(node, end)(0)
    play.executor.spin()
    play.say("executor", "returns")
