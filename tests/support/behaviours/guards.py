"""What guard conditions and waitables do."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.guard_condition import GuardCondition
from rclpy.node import Node
from rclpy.task import Future
from rclpy.waitable import NumberOfEntities, Waitable
from std_msgs.msg import Int64

from tests.support.two_executors import Play


class Bell(Waitable):
    """A waitable that a guard condition of its own wakes; it is told only once."""

    def __init__(self, play: Play, node: Node, name: str, group: CallbackGroup | None = None):
        super().__init__(group or node.default_callback_group)
        self._play = play
        self._node = node
        self._name = name
        self._guard = GuardCondition(None, None, context=node.context)
        self._number = 0
        self._rings = False
        self.then: Any = None
        node.add_waitable(self)

    def ring(self) -> None:
        self._guard.trigger()

    def destroy(self) -> None:
        self._node.remove_waitable(self)
        self._guard.destroy()

    def is_ready(self, wait_set: Any) -> bool:
        self._rings = wait_set.is_ready("guard_condition", self._number)
        return self._rings

    def take_data(self) -> str:
        return "rings" if self._rings else "is silent"

    async def execute(self, taken_data: str) -> None:
        self._play.say(self._name, taken_data)
        if self.then is not None:
            outcome = self.then()
            if outcome is not None:
                await outcome
            self._play.say(self._name, "ends")

    def get_num_entities(self) -> NumberOfEntities:
        return NumberOfEntities(0, 1, 0, 0, 0, 0)

    def add_to_wait_set(self, wait_set: Any) -> None:
        self._number = wait_set.add_guard_condition(self._guard.handle)


def a_guard_triggered_from_outside(play: Play) -> None:
    node = play.node("a")
    guard = node.create_guard_condition(lambda: play.say("guard", "called"))
    play.settle()
    guard.trigger()
    guard.trigger()
    play.settle()
    guard.trigger()
    play.settle()


def a_guard_triggered_from_a_callback(play: Play) -> None:
    node = play.node("a")
    guard = play.node("b").create_guard_condition(lambda: play.say("guard", play.ms(node)))
    node.create_timer(0.1, guard.trigger)
    play.advance(0.25)


def a_guard_that_triggers_itself_twice(play: Play) -> None:
    node = play.node("a")
    count = [0]

    def call() -> None:
        count[0] += 1
        play.say("guard", count[0])
        if count[0] < 3:
            guard.trigger()

    guard = node.create_guard_condition(call)
    guard.trigger()
    play.settle()


def a_guard_with_an_async_callback(play: Play) -> None:
    node = play.node("a")
    gate: Future = Future()

    async def call() -> None:
        play.say("guard", "begins")
        await gate
        play.say("guard", "ends")

    guard = node.create_guard_condition(call)
    guard.trigger()
    play.settle()
    gate.set_result(None)
    play.settle()


def _while_its_group_is_held(play: Play, node: Node, wake: Callable[[], None]) -> None:
    gate: Future = Future()

    async def hold() -> None:
        holding.cancel()
        await gate
        play.say("a", "lets go")

    holding = node.create_timer(0.1, hold)
    play.advance(0.15)
    wake()
    play.advance(0.2)
    gate.set_result(None)
    play.settle()


def a_guard_triggered_while_its_group_is_held_is_called_afterwards(play: Play) -> None:
    node = play.node("a")
    guard = node.create_guard_condition(lambda: play.say("a", "guard"))
    _while_its_group_is_held(play, node, guard.trigger)


def _beside_a_message(
    play: Play, node: Node, wake: Callable[[], None], hear: Callable[[Any], None]
) -> None:
    node.create_subscription(Int64, "count", hear, 10)
    node.create_publisher(Int64, "count", 10).publish(Int64(data=1))
    wake()
    play.settle()


def _making_a_timer(play: Play, node: Node) -> Callable[[Any], None]:
    def hear(message: Any) -> None:
        play.say("subscription", message.data)
        node.create_timer(1.0, lambda: None)

    return hear


def a_guard_triggered_beside_a_callback_that_makes_something(play: Play) -> None:
    node = play.node("a")
    guard = node.create_guard_condition(lambda: play.say("guard", "called"))
    _beside_a_message(play, node, guard.trigger, _making_a_timer(play, node))


def a_guard_triggered_beside_a_callback_that_raises(play: Play) -> None:
    def fail(message: Any) -> None:
        raise ValueError(f"at {message.data}")

    node = play.node("a")
    guard = node.create_guard_condition(lambda: play.say("guard", "called"))
    _beside_a_message(play, node, guard.trigger, fail)


def a_guard_destroyed_after_it_was_triggered(play: Play) -> None:
    node = play.node("a")
    guard = node.create_guard_condition(lambda: play.say("guard", "called"))
    guard.trigger()
    node.destroy_guard_condition(guard)
    play.settle()
    play.say("guard", "quiet")


def a_guard_that_raises_is_called_again(play: Play) -> None:
    node = play.node("a")

    def fail() -> None:
        play.say("guard", "called")
        raise ValueError("in a guard")

    guard = node.create_guard_condition(fail)
    for _ in range(2):
        guard.trigger()
        play.settle()


def a_waitable_of_ones_own(play: Play) -> None:
    bell = Bell(play, play.node("a"), "bell")
    play.settle()
    for _ in range(2):
        bell.ring()
        play.settle()


def a_waitable_added_and_removed_in_callbacks(play: Play) -> None:
    node = play.node("a")
    bells: list[Bell] = []

    def add() -> None:
        adding.cancel()
        bells.append(Bell(play, node, "bell"))
        bells[0].ring()

    def remove() -> None:
        removing.cancel()
        bells[0].ring()
        bells[0].destroy()
        play.say("bell", "removed")

    adding = node.create_timer(0.1, add)
    removing = node.create_timer(0.2, remove)
    play.advance(0.4)


def a_waitable_that_rings_while_its_group_is_held(play: Play) -> None:
    node = play.node("a")
    _while_its_group_is_held(play, node, Bell(play, node, "a").ring)


def a_waitable_that_rings_beside_a_callback_that_makes_something(play: Play) -> None:
    node = play.node("a")
    _beside_a_message(play, node, Bell(play, node, "bell").ring, _making_a_timer(play, node))


def two_waitables_of_which_the_first_makes_something(play: Play) -> None:
    node = play.node("a")
    first, second = Bell(play, node, "first"), Bell(play, node, "second")

    def make() -> None:
        node.create_guard_condition(lambda: None)

    first.then = make
    first.ring()
    second.ring()
    play.settle()


def a_waitable_that_awaits(play: Play) -> None:
    gate: Future = Future()
    bell = Bell(play, play.node("a"), "bell")
    bell.then = lambda: gate
    bell.ring()
    play.settle()
    play.say("bell", "waits")
    gate.set_result(None)
    play.settle()


def a_waitable_that_raises_rings_again(play: Play) -> None:
    bell = Bell(play, play.node("a"), "bell")

    def fail() -> None:
        raise ValueError("in a waitable")

    bell.then = fail
    for _ in range(2):
        bell.ring()
        play.settle()
