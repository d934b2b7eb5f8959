"""Under the lock-step executor, time moves only when nothing is in flight."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
import rclpy
from bt_mission_interfaces.action import Turn
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.task import Future
from std_msgs.msg import Int64, String
from std_srvs.srv import Trigger

from bt_mission.common.errors import BtMissionError
from bt_mission.lockstep import LockstepExecutor, NothingDueError, TimeStuckError, self_test
from bt_mission.lockstep import executor as executor_module

S = 1_000_000_000
MS = 1_000_000


def hear(callback: Callable[[Any], None]) -> Any:
    """A subscription's callback; generated messages have no types."""
    return callback


class Rig:
    """An executor with nodes made on demand."""

    def __init__(self, context: Context) -> None:
        self.context = context
        self.executor = LockstepExecutor(context=context)
        self.nodes: list[Node] = []

    def node(self, name: str) -> Node:
        node = Node(name, context=self.context, enable_rosout=False, start_parameter_services=False)
        self.nodes.append(node)
        self.executor.add_node(node)
        return node

    def now(self, node: Node) -> int:
        return int(node.get_clock().now().nanoseconds)

    def steps_until(self, time_ns: int) -> None:
        while self.executor.next_due_ns() <= time_ns:
            self.executor.step()


@pytest.fixture
def rig() -> Iterator[Rig]:
    """An executor in a context of its own."""
    context = Context()
    rclpy.init(context=context)
    rig = Rig(context)
    yield rig
    for node in rig.nodes:
        node.destroy_node()
    rig.executor.shutdown()
    context.shutdown()


def test_this_machine_delivers_at_once() -> None:
    """The self-test that virtual time rests on passes here."""
    self_test()


def test_time_starts_above_zero(rig: Rig) -> None:
    """ROS takes zero for "not set", so an executor refuses to start there."""
    with pytest.raises(ValueError, match="start_ns must be above 0"):
        LockstepExecutor(start_ns=0, context=rig.context)


def test_every_node_has_the_same_time_without_a_clock_topic(rig: Rig) -> None:
    """Nodes are on virtual time as soon as they are added, with no subscription for it."""
    a, b = rig.node("a"), rig.node("b")
    a.create_timer(0.25, lambda: None)
    rig.executor.step()
    assert rig.now(a) == rig.now(b) == S + 250 * MS
    assert not list(a.subscriptions)


def test_time_jumps_to_the_next_due_timer(rig: Rig) -> None:
    """Timers fire exactly when they are due, and nothing happens in between."""
    node = rig.node("a")
    fired: list[tuple[str, int]] = []
    node.create_timer(0.05, lambda: fired.append(("fast", rig.now(node))))
    node.create_timer(0.12, lambda: fired.append(("slow", rig.now(node))))
    rig.steps_until(S + 150 * MS)
    assert fired == [
        ("fast", S + 50 * MS),
        ("fast", S + 100 * MS),
        ("slow", S + 120 * MS),
        ("fast", S + 150 * MS),
    ]


def test_timers_of_one_instant_fire_in_the_order_of_creation_each_seeing_the_last_ones_messages(
    rig: Rig,
) -> None:
    """What the first timer publishes is delivered before the second timer fires."""
    first, second = rig.node("first"), rig.node("second")
    publisher = first.create_publisher(Int64, "count", 10)
    log: list[str] = []
    first.create_timer(0.1, lambda: publisher.publish(Int64(data=len(log))))
    second.create_subscription(Int64, "count", hear(lambda m: log.append(f"got {m.data}")), 10)
    second.create_timer(0.1, lambda: log.append("timer"))
    rig.executor.step()
    rig.executor.step()
    assert log == ["got 0", "timer", "got 2", "timer"]


def test_a_chain_of_messages_ends_within_its_instant(rig: Rig) -> None:
    """Ten hops over topics take no virtual time."""
    node = rig.node("a")
    ended: list[int] = []

    def hop(number: int) -> None:
        onward = node.create_publisher(Int64, f"hop{number + 1}", 10)
        node.create_subscription(Int64, f"hop{number}", onward.publish, 10)

    for number in range(10):
        hop(number)
    node.create_subscription(Int64, "hop10", lambda m: ended.append(rig.now(node)), 10)
    start = node.create_publisher(Int64, "hop0", 10)

    def begin() -> None:
        timer.cancel()
        start.publish(Int64())

    timer = node.create_timer(0.5, begin)
    rig.executor.step()
    assert ended == [S + 500 * MS]


def test_latched_messages_reach_a_late_subscription(rig: Rig) -> None:
    """Transient-local delivery is synchronous too."""
    node = rig.node("a")
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_publisher(String, "map", latched).publish(String(data="walls"))
    got: list[str] = []
    node.create_subscription(String, "map", hear(lambda m: got.append(m.data)), latched)
    rig.executor.run_until_quiet()
    assert got == ["walls"]


def test_a_service_call_is_answered_within_the_instant(rig: Rig) -> None:
    """A task can await a service of another node."""
    server, client = rig.node("server"), rig.node("client")

    def answer(_: Any, response: Any) -> Any:
        response.message = f"at {rig.now(server)}"
        return response

    server.create_service(Trigger, "ask", answer)
    asking = client.create_client(Trigger, "ask")
    heard: list[str] = []

    async def ask() -> None:
        heard.append((await asking.call_async(Trigger.Request())).message)

    client.create_timer(0.1, lambda: rig.executor.create_task(ask()))
    rig.executor.step()
    assert heard == [f"at {S + 100 * MS}"]


def test_a_coroutine_that_waits_blocks_its_callback_group_and_nothing_else(rig: Rig) -> None:
    """While one callback of a node is suspended, its mutually exclusive group waits with it."""
    node, other = rig.node("a"), rig.node("b")
    gate: Future = Future()
    log: list[str] = []

    async def wait_for_gate() -> None:
        slow.cancel()
        log.append("waits")
        await gate
        log.append("goes on")

    slow = node.create_timer(0.1, wait_for_gate)
    node.create_timer(0.1, lambda: log.append("same node"))
    other.create_timer(0.1, lambda: log.append("other node"))
    rig.executor.step()
    assert log == ["waits", "other node"]
    gate.set_result(None)
    rig.executor.run_until_quiet()
    assert log == ["waits", "other node", "goes on"]


def test_tasks_resume_when_what_they_await_is_done(rig: Rig) -> None:
    """``create_task`` works as under rclpy's executors, within one instant."""
    gate: Future = Future()

    async def job() -> str:
        await gate
        return "done"

    task = rig.executor.create_task(job())
    rig.executor.run_until_quiet()
    assert not task.done()
    gate.set_result(None)
    rig.executor.run_until_quiet()
    assert task.result() == "done"


def test_an_exception_in_a_callback_comes_out_of_the_step(rig: Rig) -> None:
    """Nothing is swallowed: the caller decides what a failing callback means."""

    def fail() -> None:
        raise ZeroDivisionError("in a callback")

    rig.node("a").create_timer(0.1, fail)
    with pytest.raises(ZeroDivisionError, match="in a callback"):
        rig.executor.step()


def test_an_exception_in_a_task_comes_out_of_the_step(rig: Rig) -> None:
    """Also from a coroutine that was suspended before."""

    async def fail() -> None:
        raise ZeroDivisionError("in a task")

    rig.executor.create_task(fail())
    with pytest.raises(ZeroDivisionError, match="in a task"):
        rig.executor.run_until_quiet()


def test_time_that_cannot_advance_is_reported_with_the_culprit(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A callback that publishes to itself for ever is named instead of hanging."""
    monkeypatch.setattr(executor_module, "CALLBACKS_PER_INSTANT", 200)
    node = rig.node("a")
    echo = node.create_publisher(Int64, "echo", 10)
    node.create_subscription(Int64, "echo", echo.publish, 10)
    node.create_timer(0.1, lambda: echo.publish(Int64()))
    with pytest.raises(TimeStuckError, match=r"stuck at 1\.100 s.*Subscription /echo"):
        rig.executor.step()


def test_without_timers_and_world_time_cannot_move(rig: Rig) -> None:
    """There is nothing to jump to, and the message says so."""
    rig.node("a")
    with pytest.raises(NothingDueError, match="no timer is set"):
        rig.executor.step()


def test_a_timer_on_another_clock_is_refused(rig: Rig) -> None:
    """A wall timer would make a run depend on the machine."""
    node = rig.node("a")
    wall = rclpy.clock.Clock(clock_type=rclpy.clock.ClockType.STEADY_TIME)
    node.create_timer(0.1, lambda: None, clock=wall)
    with pytest.raises(BtMissionError, match="STEADY_TIME clock cannot run in virtual time"):
        rig.executor.step()


def test_the_world_moves_first(rig: Rig) -> None:
    """At each due instant the world publishes before any timer fires."""
    node = rig.node("a")
    publisher = node.create_publisher(Int64, "scan", 10)
    log: list[str] = []

    class World:
        next_due_ns = S + 70 * MS

        def advance_to(self, time_ns: int) -> None:
            if time_ns >= self.next_due_ns:
                publisher.publish(Int64(data=self.next_due_ns))
                self.next_due_ns += 70 * MS

    rig.executor.world = World()
    node.create_subscription(Int64, "scan", hear(lambda m: log.append(f"scan {m.data // MS}")), 10)
    node.create_timer(0.14, lambda: log.append("timer"))
    rig.executor.step()
    rig.executor.step()
    assert log == ["scan 1070", "scan 1140", "timer"]


def test_entities_made_in_a_callback_are_served_at_once(rig: Rig) -> None:
    """A subscription made at one instant hears what is published at the same instant."""
    node = rig.node("a")
    got: list[int] = []
    publisher = node.create_publisher(Int64, "late", 10)

    def make() -> None:
        timer.cancel()
        node.create_subscription(Int64, "late", hear(lambda m: got.append(m.data)), 10)

    timer = node.create_timer(0.1, make)
    node.create_timer(0.1, lambda: publisher.publish(Int64(data=7)))
    rig.executor.step()
    assert got == [7]


def test_a_timer_destroyed_by_an_earlier_one_does_not_fire(rig: Rig) -> None:
    """Destruction takes effect within the instant."""
    node = rig.node("a")
    fired: list[str] = []
    node.create_timer(0.1, lambda: node.destroy_timer(doomed))
    doomed = node.create_timer(0.1, lambda: fired.append("doomed"))
    rig.executor.step()
    assert fired == []


def test_a_removed_node_is_served_no_more(rig: Rig) -> None:
    """Its timers stop, and the others go on."""
    a, b = rig.node("a"), rig.node("b")
    fired: list[str] = []
    a.create_timer(0.1, lambda: fired.append("a"))
    b.create_timer(0.1, lambda: fired.append("b"))
    rig.executor.step()
    rig.executor.remove_node(a)
    rig.executor.step()
    assert fired == ["a", "b", "b"]


def test_an_action_from_goal_to_result_in_exact_virtual_times(rig: Rig) -> None:
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

    async def story() -> None:
        timer.cancel()
        handle = await client.send_goal_async(Turn.Goal(angle=90.0))
        log.append(("accepted", rig.now(asking)))
        later = asking.create_timer(1.0, lambda: (later.cancel(), handle.cancel_goal_async()))
        result = await handle.get_result_async()
        log.append((f"status {result.status}, {result.result.angle_turned}", rig.now(asking)))

    def begin() -> None:
        timer.cancel()
        rig.executor.create_task(story())

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
