"""Code that blocks lets virtual time go on, wherever it blocks."""

from __future__ import annotations

import asyncio
import datetime as dt
import queue
import random
import sys
import threading
import time
import uuid
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from threading import Thread
from time import sleep
from typing import Any

import pytest
import rclpy
import rclpy.executors
from example_interfaces.action import Fibonacci
from example_interfaces.srv import AddTwoInts
from rclpy.action import ActionClient, ActionServer
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.task import Future
from rclpy.wait_for_message import wait_for_message
from std_msgs.msg import Int64
from std_srvs.srv import Trigger

from bt_mission.programs.replaced import REPLACED, adopt
from bt_mission.programs.stuck import DeadlockError
from tests.support.thorough import sample

ORIGINALS = {
    (module.__name__, name): vars(module)[name] for module, names in REPLACED for name in names
}


class Numbers(Node):
    """Adds in a second, counts in 0.25 s, and sets an event at the fourth count."""

    def __init__(self, **options: Any) -> None:
        super().__init__("numbers", enable_rosout=False, start_parameter_services=False, **options)
        self.count = 0
        self.fourth = threading.Event()
        group = ReentrantCallbackGroup()
        self.create_timer(0.25, self.beat)
        self.publisher = self.create_publisher(Int64, "count", 1)
        self.create_service(AddTwoInts, "add", self.add, callback_group=group)
        self.adder = self.create_client(AddTwoInts, "add", callback_group=group)
        self.server = ActionServer(self, Fibonacci, "fib", self.execute, callback_group=group)
        self.asker = ActionClient(self, Fibonacci, "fib", callback_group=group)

    def beat(self) -> None:
        self.count += 1
        self.publisher.publish(Int64(data=self.count))
        if self.count == 4:
            self.fourth.set()

    def add(self, request: Any, response: Any) -> Any:
        time.sleep(1)
        response.sum = request.a + request.b
        return response

    def execute(self, goal: Any) -> Any:
        rate = self.create_rate(10)
        for _ in range(goal.request.order):
            rate.sleep()
        goal.succeed()
        return Fibonacci.Result(sequence=[goal.request.order])


def asked(node: Numbers) -> Any:
    return node.adder.call_async(AddTwoInts.Request(a=1, b=2))


def in_thread(function: Callable[[], Any]) -> Thread:
    thread = Thread(target=function)
    thread.start()
    return thread


def sleeps(node: Numbers) -> None:
    time.sleep(1.5)
    sleep(0.5)


def gives_way(_node: Numbers) -> None:
    for _ in range(2500):
        time.sleep(0)


def uses_a_rate(node: Numbers) -> None:
    rate = node.create_rate(10)
    for _ in range(10):
        rate.sleep()


def sleeps_on_clocks(node: Numbers) -> Any:
    steady = Clock(clock_type=ClockType.STEADY_TIME)
    before = steady.now()
    return (
        node.get_clock().sleep_for(Duration(seconds=0.5)),
        steady.sleep_until(steady.now() + Duration(seconds=0.5)),
        (steady.now() - before).nanoseconds,
    )


def polls_a_future(node: Numbers) -> int:
    future = asked(node)
    while not future.done():
        time.sleep(0.1)
    return int(future.result().sum)


def spins_until(node: Numbers) -> int:
    future = asked(node)
    rclpy.spin_until_future_complete(node, future)
    return int(future.result().sum)


def spins_once_and_again(node: Numbers) -> int:
    while node.count < 3:
        rclpy.spin_once(node)
    return node.count


def spins_another_node(node: Numbers) -> int:
    other = rclpy.create_node("other", context=node.context)
    client = other.create_client(AddTwoInts, "add")
    executor = rclpy.executors.SingleThreadedExecutor(context=node.context)
    executor.add_node(other)
    future = client.call_async(AddTwoInts.Request(a=2, b=2))
    executor.spin_until_future_complete(future)
    other.destroy_node()
    return int(future.result().sum)


def waits_for_nobody(node: Numbers) -> Any:
    nobody = node.create_client(Trigger, "nobody")
    return nobody.wait_for_service(timeout_sec=1), node.asker.wait_for_server(timeout_sec=1)


def joins(_: Numbers) -> Any:
    thread = in_thread(lambda: time.sleep(1))
    thread.join(0.25)
    alive = thread.is_alive()
    thread.join()
    return alive, thread.is_alive()


def takes_from_a_queue(_: Numbers) -> Any:
    items: queue.Queue[int] = queue.Queue(1)

    def put() -> None:
        for number in range(3):
            time.sleep(0.5)
            items.put(number)

    in_thread(put)
    taken = [items.get() for _ in range(3)]
    with pytest.raises(queue.Empty):
        items.get(timeout=0.5)
    return taken


def uses_a_pool(_: Numbers) -> Any:
    def wait(seconds: float) -> float:
        time.sleep(seconds)
        return seconds

    with ThreadPoolExecutor(2) as pool:
        done = as_completed([pool.submit(wait, seconds) for seconds in (1, 0.5, 0.25)])
        return [future.result() for future in done]


def locks(_: Numbers) -> Any:
    lock = threading.Lock()
    order: list[str] = []

    def hold(name: str) -> None:
        with lock:
            time.sleep(0.5)
            order.append(name)

    threads = [in_thread(lambda name=name: hold(name)) for name in "abc"]
    got = lock.acquire(timeout=0.25), lock.acquire(blocking=False)
    for thread in threads:
        thread.join()
    return got, "".join(order)


def locks_again(_: Numbers) -> None:
    lock = threading.RLock()

    def hold() -> None:
        with lock, lock:
            time.sleep(0.5)

    in_thread(hold)
    with lock:
        pass


def waits_for_a_condition(_: Numbers) -> Any:
    condition = threading.Condition()
    items: list[int] = []

    def put() -> None:
        time.sleep(0.5)
        with condition:
            items.append(1)
            condition.notify_all()

    in_thread(put)
    with condition:
        return condition.wait_for(lambda: items, timeout=2)


def meets(_: Numbers) -> Any:
    barrier, semaphore = threading.Barrier(2), threading.Semaphore(0)
    threading.Timer(0.5, barrier.wait).start()
    barrier.wait()
    threading.Timer(0.5, semaphore.release).start()
    return semaphore.acquire(timeout=2)


def polls(node: Numbers) -> None:
    end_s = time.time() + 0.05
    while time.time() < end_s:
        pass
    end = node.get_clock().now() + Duration(seconds=0.05)
    while node.get_clock().now() < end:
        pass


def reads_clocks(node: Numbers) -> Any:
    before = dt.datetime.now()
    time.sleep(1)
    clocks = {time.time(), time.monotonic(), time.perf_counter(), time.time_ns() / 1e9}
    clocks.add(node.get_clock().now().nanoseconds / 1e9)
    passed = dt.datetime.now() - before
    return clocks, passed.total_seconds(), time.strftime("%S", time.gmtime())


def has_its_own(_: Numbers) -> Any:
    own = threading.local()
    seen: list[Any] = []
    own.value = 1

    def look() -> None:
        seen.append((hasattr(own, "value"), threading.current_thread().name))
        seen.append(threading.get_ident())

    thread = Thread(target=look, name="other")
    thread.start()
    thread.join()
    return seen[0], seen[1] == thread.ident != threading.get_ident(), own.value


CASES: list[tuple[Callable[[Numbers], Any], float, Any]] = [
    (sleeps, 2.0, None),
    (gives_way, 0.012, None),
    (uses_a_rate, 1.0, None),
    (sleeps_on_clocks, 1.0, (True, True, 1_000_000_000)),
    (lambda node: node.fourth.wait(), 1.0, True),
    (lambda node: node.fourth.wait(0.5), 0.5, False),
    (lambda node: node.adder.call(AddTwoInts.Request(a=1, b=2)).sum, 1.0, 3),
    (lambda node: list(node.asker.send_goal(Fibonacci.Goal(order=5)).result.sequence), 0.5, [5]),
    (polls_a_future, 1.1, 3),
    (spins_until, 1.0, 3),
    (lambda node: rclpy.spin_until_future_complete(node, Future(), timeout_sec=0.7), 0.7, None),
    (spins_once_and_again, 0.75, 3),
    (spins_another_node, 1.0, 4),
    (waits_for_nobody, 1.0, (False, True)),
    (lambda node: wait_for_message(Int64, node, "count")[1].data, 0.25, 1),
    (lambda node: wait_for_message(Int64, node, "silent", time_to_wait=2), 2.0, (False, None)),
    (joins, 1.0, (True, False)),
    (takes_from_a_queue, 2.0, [0, 1, 2]),
    (uses_a_pool, 1.0, [0.5, 0.25, 1]),
    (locks, 1.5, ((False, False), "abc")),
    (locks_again, 0.5, None),
    (waits_for_a_condition, 0.5, [1]),
    (meets, 1.0, True),
    (polls, 0.1, None),
    (reads_clocks, 1.0, ({2.0}, 1.0, "02")),
    (has_its_own, 0.0, ((False, "other"), True, 1)),
]


@pytest.mark.parametrize(("code", "seconds", "result"), sample(CASES, 2))
def test_what_blocks_takes_virtual_time(
    programs: Any, code: Callable[[Numbers], Any], seconds: float, result: Any
) -> None:
    """Exactly as much as it says; other callbacks run meanwhile."""
    adopt(code)
    assert programs.run(code, programs.add(Numbers)) == (seconds, result)


def made_here() -> Any:
    """What this code gets that programs get another one of: objects, and times above a year."""
    kinds: tuple[Any, ...] = (
        threading.Lock(),
        threading.RLock(),
        threading.local(),
        queue.SimpleQueue(),
    )
    others = (threading.Timer(1, print), threading.Thread(), rclpy.context.Context())
    clocks = (time.time(), time.time_ns() / 1e9, dt.datetime.now().timestamp())
    return [type(each) for each in (*kinds, *others)], [now > 3e7 for now in clocks]


ORIGINAL_KINDS = made_here()


def test_nothing_else_gets_what_programs_get(programs: Any) -> None:
    """A replaced function does as the original in other callbacks and threads."""
    seen: list[Any] = []
    inside: list[Any] = []

    def look() -> Any:
        # A thread of the process, as a library may have started it before.
        other = ORIGINALS["threading", "Thread"](target=lambda: seen.append(made_here()))
        ORIGINALS["threading", "Thread"].start(other)
        ORIGINALS["threading", "Thread"].join(other)
        inside.extend(made_here())
        time.sleep(0.1)

    def originals() -> Any:
        return {key: vars(sys.modules[key[0]])[key[1]] for key in ORIGINALS}

    programs.rig.node("ours").create_timer(0.05, lambda: seen.append(made_here()))
    programs.run(look)
    assert len(seen) > 1
    assert [each for each in seen if each != ORIGINAL_KINDS] == []
    assert not {*inside[0]} & {*ORIGINAL_KINDS[0]}
    assert inside[1] == [False, False, False]
    programs.host.close()
    assert originals() == ORIGINALS


def test_a_loop_that_runs_the_stage_does_not_run_programs(programs: Any) -> None:
    """As for a page in a browser: it is still there afterwards, and a program runs its own."""

    def sleep() -> bool:
        time.sleep(1)
        asyncio.run(asyncio.sleep(1))
        return asyncio._get_running_loop() is None

    async def run() -> None:
        loop = asyncio.get_running_loop()
        assert programs.run(sleep) == (2, True)
        assert asyncio.get_running_loop() is loop

    asyncio.run(run())


def test_random_numbers_of_a_program_follow_from_its_seed(programs: Any) -> None:
    """So do the ids of goals that rclpy draws. Those of others do not change."""

    def draw() -> Any:
        return random.random(), random.choice("abcdef"), uuid.uuid4()

    first = programs.run(draw)[1]
    programs.program = programs.host.program("again", "0", programs.rig.context)
    assert programs.run(draw)[1] == first
    programs.program = programs.host.program("other", "1", programs.rig.context)
    assert programs.run(draw)[1] != first


def test_a_node_may_wait_while_it_is_made(programs: Any) -> None:
    """For a server, as the clients of ROS's own tutorials do."""

    class Client(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("client", **options)
            client = self.create_client(Trigger, "late")
            while not client.wait_for_service(timeout_sec=1.0):
                self.get_logger().debug("not available")

    node = programs.rig.node("server")
    programs.rig.clock.call_at(
        programs.rig.clock.now_ns + 2_500_000_000,
        lambda: node.create_service(Trigger, "late", lambda _, response: response),
    )
    programs.add(Client)
    assert programs.rig.now_s == 2.5


def two_locks(_: Any) -> None:
    first, second = threading.Lock(), threading.Lock()

    def hold() -> None:
        with first:
            time.sleep(0.1)
            with second:
                pass

    in_thread(hold)
    with second:
        time.sleep(0.2)
        with first:
            pass


def joins_each_other(_: Any) -> None:
    threads: list[Thread] = []
    threads.append(in_thread(lambda: (time.sleep(0.1), threads[1].join())))
    threads.append(in_thread(threads[0].join))
    threads[0].join()


@pytest.mark.parametrize(
    ("code", "places"),
    [
        (two_locks, r"\(\S+:\d+\) waits for a lock, and two_locks.hold \(\S+:\d+\) waits"),
        (joins_each_other, r"joins_each_other.<lambda> \(\S+:\d+\) waits for the end of a thread"),
    ],
)
def test_code_that_waits_for_itself_is_named(programs: Any, code: Any, places: str) -> None:
    """At once, with the place of each."""
    with pytest.raises(DeadlockError, match=f"a deadlock: .*{places}"):
        programs.run(code, None)
    assert programs.rig.now_s <= 0.2


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_an_exception_of_a_thread_ends_the_thread_alone(programs: Any) -> None:
    """As in Python, whose hook is called."""

    def fails() -> bool:
        thread = in_thread(lambda: 1 / 0)
        thread.join()
        return thread.is_alive()

    assert programs.run(fails) == (0.0, False)


def test_calls_end_with_their_host(programs: Any) -> None:
    """Their code runs `finally`, and cannot wait any more."""
    ended: list[str] = []

    def waits() -> None:
        try:
            threading.Event().wait()
        finally:
            try:
                time.sleep(1)
            finally:
                ended.append("over")

    programs.program.executor.create_task(waits)
    programs.rig.clock.run_until_quiet()
    programs.host.close()
    assert ended == ["over"]
    assert not programs.host.calls
