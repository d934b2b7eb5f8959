"""What subscriptions do."""

from __future__ import annotations

from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rclpy.task import Future
from std_msgs.msg import Int64

from tests.support.two_executors import Play

LATCHED = QoSProfile(depth=3, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def messages_reach_several_nodes_in_order(play: Play) -> None:
    sender = play.node("sender")
    publisher = sender.create_publisher(Int64, "count", 10)
    for name in ("one", "two", "three"):
        play.node(name).create_subscription(Int64, "count", play.hear(name), 10)
    for number in range(5):
        publisher.publish(Int64(data=number))
    play.settle()


def of_a_full_queue_the_oldest_are_lost(play: Play) -> None:
    node = play.node("a")
    publisher = node.create_publisher(Int64, "count", 10)
    node.create_subscription(Int64, "count", play.hear("depth 2"), 2)
    everything = QoSProfile(history=HistoryPolicy.KEEP_ALL)
    node.create_subscription(Int64, "count", play.hear("keep all"), everything)
    for number in range(5):
        publisher.publish(Int64(data=number))
    play.settle()


def best_effort_reaches_within_the_process(play: Play) -> None:
    node = play.node("a")
    qos = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
    publisher = node.create_publisher(Int64, "count", qos)
    play.node("b").create_subscription(Int64, "count", play.hear("b"), qos)
    for number in range(5):
        publisher.publish(Int64(data=number))
    play.settle()


def policies_that_do_not_fit_stay_silent(play: Play) -> None:
    node = play.node("a")
    qos = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
    publisher = node.create_publisher(Int64, "count", qos)
    node.create_subscription(Int64, "count", play.hear("b"), QoSProfile(depth=10))
    publisher.publish(Int64(data=1))
    play.settle()
    play.say("a", publisher.get_subscription_count())


def a_latched_message_reaches_one_that_comes_later(play: Play) -> None:
    publisher = play.node("a").create_publisher(Int64, "count", LATCHED)
    for number in range(5):
        publisher.publish(Int64(data=number))
    play.settle()
    play.node("b").create_subscription(Int64, "count", play.hear("b"), LATCHED)
    play.wait_for(lambda: len(play.log["b"]) == 3)


def a_volatile_message_does_not_reach_one_that_comes_later(play: Play) -> None:
    publisher = play.node("a").create_publisher(Int64, "count", 10)
    publisher.publish(Int64(data=1))
    play.settle()
    play.node("b").create_subscription(Int64, "count", play.hear("b"), 10)
    publisher.publish(Int64(data=2))
    play.settle()


def a_chain_over_topics(play: Play) -> None:
    node = play.node("a")

    def link(number: int) -> None:
        onward = node.create_publisher(Int64, f"hop{number + 1}", 10)

        def pass_on(message: Any) -> None:
            play.say(f"hop {number}", message.data)
            onward.publish(Int64(data=message.data + 1))

        node.create_subscription(Int64, f"hop{number}", pass_on, 10)

    for number in range(5):
        link(number)
    start = node.create_publisher(Int64, "hop0", 10)
    node.create_timer(0.1, lambda: start.publish(Int64()))
    play.advance(0.3)


def a_callback_that_publishes_to_itself_until_it_has_enough(play: Play) -> None:
    def echo(message: Any) -> None:
        play.say("a", message.data)
        if message.data < 10:
            publish(message.data + 1)

    publish = play.pipe(play.node("a"), echo)
    publish(0)
    play.settle()


def what_comes_with_a_message(play: Play) -> None:
    node = play.node("a")

    def with_info(message: Any, info: dict[str, Any]) -> None:
        play.say("a", (message.data, sorted(info)))

    def raw(data: bytes) -> None:
        play.say("raw", deserialize_message(data, Int64).data)

    publish = play.pipe(node, with_info)
    node.create_subscription(Int64, "count", raw, 10, raw=True)
    publish(7)
    play.settle()


def a_callback_that_raises_is_called_for_the_next_message(play: Play) -> None:
    def fail(message: Any) -> None:
        play.say("a", message.data)
        if message.data % 2:
            raise ValueError(f"odd: {message.data}")

    play.pipe(play.node("a"), fail)(*range(4))
    play.settle()


def an_async_callback_has_the_next_message_wait(play: Play) -> None:
    _two_messages_to_an_async_callback(play, None)


def an_async_callback_in_a_reentrant_group_takes_the_next_message(play: Play) -> None:
    _two_messages_to_an_async_callback(play, ReentrantCallbackGroup())


def _two_messages_to_an_async_callback(play: Play, group: Any) -> None:
    gates: dict[int, Future] = {1: Future(), 2: Future()}

    async def hear(message: Any) -> None:
        play.say("a", f"{message.data} begins")
        await gates[message.data]
        play.say("a", f"{message.data} ends")

    play.pipe(play.node("a"), hear, callback_group=group)(*gates)
    play.settle()
    play.say("a", "the second may end")
    play.release(gates[2])
    play.release(gates[1])


def a_subscription_destroyed_in_its_callback_hears_no_more(play: Play) -> None:
    node = play.node("a")
    publisher = node.create_publisher(Int64, "count", 10)

    def once(message: Any) -> None:
        play.say("a", message.data)
        node.destroy_subscription(subscription)

    subscription = node.create_subscription(Int64, "count", once, 10)
    for number in range(3):
        publisher.publish(Int64(data=number))
    play.settle()
    play.say("a", publisher.get_subscription_count())


def a_subscription_created_in_a_callback_hears_what_comes_next(play: Play) -> None:
    node = play.node("a")
    publisher = node.create_publisher(Int64, "count", 10)

    def join(message: Any) -> None:
        play.say("first", message.data)
        if message.data == 0:
            node.create_subscription(Int64, "count", play.hear("second"), 10)
            publisher.publish(Int64(data=1))

    node.create_subscription(Int64, "count", join, 10)
    publisher.publish(Int64(data=0))
    play.settle()


def a_publisher_destroyed_after_it_has_spoken_is_heard(play: Play) -> None:
    node = play.node("a")
    publisher = node.create_publisher(Int64, "count", 10)
    play.node("b").create_subscription(Int64, "count", play.hear("b"), 10)
    publisher.publish(Int64(data=1))
    node.destroy_publisher(publisher)
    play.settle()
