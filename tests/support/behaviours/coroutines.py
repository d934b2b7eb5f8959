"""What tasks, futures and coroutines do."""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

from rclpy.task import Future

from tests.support.two_executors import Play


class Turn:
    """Awaited, it lets the executor do something else once."""

    def __await__(self) -> Generator[None, None, None]:
        yield


def tasks_of_each_kind_give_their_results(play: Play) -> None:
    async def coroutine(a: int, b: int) -> int:
        return a + b

    tasks = {
        "function": play.executor.create_task(lambda a, b: a + b, 1, b=2),
        "coroutine function": play.executor.create_task(coroutine, 3, b=4),
        "coroutine": play.executor.create_task(coroutine(5, 6)),
    }
    play.say("done before", [task.done() for task in tasks.values()])
    play.settle()
    for name, task in tasks.items():
        play.say(name, task.result())


def a_task_awaits_a_future_that_a_timer_sets(play: Play) -> None:
    node = play.node("a")
    gate: Future = Future()
    node.create_timer(0.3, lambda: gate.set_result("rings"))

    async def wait() -> None:
        play.say("task", "waits")
        play.say("task", f"{await gate} at {play.ms(node)}")

    play.executor.create_task(wait())
    play.advance(0.5)


def a_task_awaits_a_task(play: Play) -> None:
    gate: Future = Future()

    async def inner() -> str:
        await gate
        return "inner"

    async def outer() -> None:
        play.say("outer", await play.executor.create_task(inner()))

    play.executor.create_task(outer())
    play.settle()
    play.release(gate)


def a_task_that_raises(play: Play) -> None:
    async def fail() -> None:
        raise ValueError("in a task")

    task = play.executor.create_task(fail())
    play.settle()
    play.say("task", (task.done(), repr(task.exception())))


def a_task_that_awaits_one_that_raises(play: Play) -> None:
    async def fail() -> None:
        raise ValueError("in a task")

    failing = play.executor.create_task(fail())

    async def outer() -> None:
        try:
            await failing
        except ValueError as error:
            play.say("outer", error)

    play.executor.create_task(outer())
    play.settle()


def a_function_that_raises_as_a_task(play: Play) -> None:
    task = play.executor.create_task(lambda: 1 // 0)
    play.settle()
    play.say("task", repr(task.exception()))


def the_other_tasks_go_on_when_one_raises(play: Play) -> None:
    gate: Future = Future()

    async def wait(name: str) -> None:
        await gate
        play.say(name, "ends")

    async def fail() -> None:
        await gate
        raise ValueError("in a task")

    for coroutine in (wait("before"), fail(), wait("after")):
        play.executor.create_task(coroutine)
    play.settle()
    play.release(gate)


def a_future_that_is_given_an_exception(play: Play) -> None:
    gate: Future = Future()

    async def wait() -> None:
        try:
            await gate
        except ValueError as error:
            play.say("task", error)

    play.executor.create_task(wait())
    play.settle()
    gate.set_exception(ValueError("given"))
    play.settle()


def a_future_that_is_cancelled_gives_nothing(play: Play) -> None:
    gate: Future = Future()

    async def wait() -> None:
        play.say("task", await gate)

    play.executor.create_task(wait())
    play.settle()
    gate.cancel()
    play.settle()


def a_task_that_is_cancelled_while_it_waits(play: Play) -> None:
    gate: Future = Future()

    async def wait() -> None:
        try:
            await gate
        finally:
            play.say("task", "leaves")

    task = play.executor.create_task(wait())
    play.settle()
    task.cancel()
    play.release(gate)
    play.say("task", (task.done(), task.cancelled()))


def a_task_that_is_cancelled_before_it_begins(play: Play) -> None:
    task = play.executor.create_task(lambda: play.say("task", "runs"))
    task.cancel()
    play.settle()
    play.say("task", (task.done(), task.cancelled()))


def callbacks_of_a_task_are_called_when_it_is_done(play: Play) -> None:
    task = play.executor.create_task(lambda: 5)
    task.add_done_callback(lambda f: play.say("early", f.result()))
    play.settle()
    task.add_done_callback(lambda f: play.say("late", f.result()))
    play.say("late", "added")
    play.settle()


def a_callback_of_a_task_that_raises(play: Play) -> None:
    task = play.executor.create_task(lambda: 5)
    task.add_done_callback(lambda f: 1 // 0)
    task.add_done_callback(lambda f: play.say("other", f.result()))
    play.settle()


def a_callback_of_a_future_is_called_at_once_where_no_executor_has_it(play: Play) -> None:
    gate: Future = Future()
    gate.add_done_callback(lambda f: play.say("a", f.result()))
    gate.set_result("called")
    play.say("a", "set")
    play.settle()


def tasks_that_make_tasks(play: Play) -> None:
    def spawn(depth: int) -> None:
        play.say(f"depth {depth}", "runs")
        if depth < 4:
            for _ in range(2):
                play.executor.create_task(spawn, depth + 1)

    play.executor.create_task(spawn, 0)
    play.settle()


def a_task_made_in_a_callback(play: Play) -> None:
    node = play.node("a")

    async def job() -> None:
        play.say("a", f"task at {play.ms(node)}")

    def fire() -> None:
        play.executor.create_task(job())
        play.say("a", "timer")

    node.create_timer(0.1, fire)
    play.advance(0.25)


def an_async_callback_that_awaits_nothing(play: Play) -> None:
    node = play.node("a")

    async def fire() -> None:
        play.say("a", play.ms(node))

    node.create_timer(0.1, fire)
    play.advance(0.25)


def a_suspended_callback_that_raises_frees_its_group(play: Play) -> None:
    node = play.node("a")
    gate: Future = Future()

    async def fail() -> None:
        failing.cancel()
        await gate
        raise ValueError("after waiting")

    failing = node.create_timer(0.1, fail)
    node.create_timer(0.15, lambda: play.say("other", play.ms(node)))
    play.advance(0.35)
    play.release(gate)
    play.advance(0.3)


def a_coroutine_that_asks_again_and_again_ends_once_it_is_so(play: Play) -> None:
    """When exactly is another matter: ours gives it a turn a round, rclpy's turns without end."""
    node = play.node("a")
    flag: list[Any] = []
    node.create_timer(0.3, lambda: flag.append(True))

    async def poll() -> None:
        while not flag:
            await Turn()
        play.say("task", "seen")

    play.executor.create_task(poll())
    play.advance(0.5)


def several_awaits_in_a_row(play: Play) -> None:
    gates = [Future() for _ in range(4)]

    async def wait() -> None:
        for number, gate in enumerate(gates):
            await gate
            play.say("task", number)

    play.executor.create_task(wait())
    for number in (0, 2, 1, 3):
        play.release(gates[number])
        play.say("task", f"gate {number} was open")
