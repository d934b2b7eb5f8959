"""What timers do."""

from __future__ import annotations

from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.task import Future
from rclpy.timer import Timer

from tests.support.two_executors import MS, Play


def three_periods_on_one_node(play: Play) -> None:
    node = play.node("a")
    for period in (0.1, 0.15, 0.25):
        node.create_timer(period, lambda name=f"every {period}": play.say(name, play.ms(node)))
    play.advance(1.0)


def timers_of_one_instant_fire_in_the_order_of_creation(play: Play) -> None:
    node = play.node("a")
    for name in ("first", "second", "third"):
        node.create_timer(0.2, lambda name=name: play.say("a", name))
    play.advance(0.5)


def a_timer_that_cancels_itself(play: Play) -> None:
    node = play.node("a")

    def fire() -> None:
        play.say("a", play.ms(node))
        timer.cancel()

    timer = node.create_timer(0.1, fire)
    play.advance(0.5)
    play.say("a", timer.is_canceled())


def a_timer_that_is_reset_starts_its_period_anew(play: Play) -> None:
    node = play.node("a")
    timer = node.create_timer(0.2, lambda: play.say("reset", play.ms(node)))
    node.create_timer(0.15, lambda: (timer.reset(), resetting.cancel()))
    resetting: Any = list(node.timers)[1]
    play.advance(0.8)


def a_cancelled_timer_that_is_reset_goes_on(play: Play) -> None:
    node = play.node("a")
    timer = node.create_timer(0.1, lambda: play.say("a", play.ms(node)))
    timer.cancel()
    play.advance(0.3)
    play.say("a", "reset")
    timer.reset()
    play.say("a", timer.time_until_next_call())
    play.advance(0.25)


def a_timer_that_does_not_start_by_itself(play: Play) -> None:
    node = play.node("a")
    timer = node.create_timer(0.1, lambda: play.say("a", play.ms(node)), autostart=False)
    play.advance(0.3)
    timer.reset()
    play.advance(0.25)


def a_period_that_is_changed_in_the_callback(play: Play) -> None:
    node = play.node("a")

    def fire() -> None:
        play.say("a", play.ms(node))
        timer.timer_period_ns += 50 * MS

    timer = node.create_timer(0.1, fire)
    play.advance(1.5)


def a_timer_created_in_a_callback(play: Play) -> None:
    node = play.node("a")

    def fire() -> None:
        outer.cancel()
        node.create_timer(0.1, lambda: play.say("inner", play.ms(node)))

    outer = node.create_timer(0.15, fire)
    play.advance(0.5)


def a_timer_destroyed_by_an_earlier_one_of_its_instant(play: Play) -> None:
    node = play.node("a")

    def destroy() -> None:
        play.say("a", play.ms(node))
        node.destroy_timer(doomed)

    node.create_timer(0.1, destroy)
    doomed = node.create_timer(0.1, lambda: play.say("a", "doomed"))
    play.advance(0.25)


def a_timer_cancelled_by_an_earlier_one_of_its_instant(play: Play) -> None:
    node = play.node("a")
    doomed: Timer

    def cancel() -> None:
        doomed.cancel()

    node.create_timer(0.1, cancel)
    doomed = node.create_timer(0.1, lambda: play.say("a", "doomed"))
    play.advance(0.25)
    play.say("a", doomed.is_canceled())


def a_timer_destroyed_in_its_own_callback(play: Play) -> None:
    node = play.node("a")

    def destroy() -> None:
        play.say("a", play.ms(node))
        node.destroy_timer(timer)

    timer = node.create_timer(0.1, destroy)
    play.advance(0.35)


def a_callback_that_takes_three_periods(play: Play) -> None:
    """Those that it missed are left out, and the phase is kept."""
    node = play.node("a")
    ends: list[Future] = []

    async def fire() -> None:
        play.say("slow", f"begins at {play.ms(node)}")
        ends.append(Future())
        await ends[-1]
        play.say("slow", f"ends at {play.ms(node)}")

    node.create_timer(0.1, fire)
    play.advance(0.45)
    ends.pop().set_result(None)
    play.advance(0.2)
    ends.pop().set_result(None)
    play.advance(0.1)


def a_slow_callback_in_a_reentrant_group_is_overtaken(play: Play) -> None:
    node = play.node("a")
    gate: Future = Future()
    count = [0]

    async def fire() -> None:
        count[0] += 1
        number = count[0]
        play.say(f"call {number}", f"begins at {play.ms(node)}")
        await gate
        play.say(f"call {number}", f"ends at {play.ms(node)}")

    node.create_timer(0.1, fire, callback_group=ReentrantCallbackGroup())
    play.advance(0.35)
    gate.set_result(None)
    play.advance(0.1)


def a_timer_that_raises_fires_again(play: Play) -> None:
    node = play.node("a")

    def fire() -> None:
        play.say("a", play.ms(node))
        raise ValueError("in a timer")

    node.create_timer(0.1, fire)
    node.create_timer(0.1, lambda: play.say("beside", play.ms(node)))
    play.advance(0.35)


def what_a_timer_tells_of_itself(play: Play) -> None:
    node = play.node("a")
    timer = node.create_timer(0.2, lambda: None)
    play.say("a", timer.time_until_next_call())
    play.advance(0.05)
    play.say("a", (timer.time_since_last_call(), timer.time_until_next_call(), timer.is_ready()))
    play.advance(0.15)
    play.say("a", (timer.time_since_last_call(), timer.time_until_next_call(), timer.is_ready()))
