"""Under the lock-step executor, time moves only when nothing is in flight; rclpy's spins, too."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import pytest
import rclpy
from bt_mission_interfaces.action import Turn
from rclpy.action import ActionClient, ActionServer
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.task import Future
from std_msgs.msg import Int64
from std_srvs.srv import Trigger

from bt_mission.base.errors import BtMissionError
from bt_mission.ros.virtual_time import (
    DiscoveryError,
    NestedStepError,
    NothingDueError,
    NoVirtualTimeError,
    TimeStuckError,
    VirtualTimeExecutor,
    discovery,
    self_test,
)
from bt_mission.ros.virtual_time import executor as executor_module

S = 1_000_000_000
MS = 1_000_000


def hear(callback: Callable[[Any], None]) -> Any:
    """A subscription's callback; generated messages have no types."""
    return callback


def step_for_ever(executor: VirtualTimeExecutor) -> None:
    """Until something is raised."""
    while True:
        executor.step()


def test_a_machine_on_which_messages_come_late_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """With what to set: virtual time would not repeat there. This machine delivers at once."""
    self_test()
    self_test.cache_clear()
    monkeypatch.setattr(VirtualTimeExecutor, "run_until_quiet", lambda self: None)
    with pytest.raises(
        NoVirtualTimeError, match=r"50 of 50 exchanges .* were late with rmw_fastrtps"
    ):
        self_test()


def test_time_starts_above_zero(rig: Any) -> None:
    """ROS takes zero for "not set", so an executor refuses to start there."""
    with pytest.raises(ValueError, match="start_ns must be above 0"):
        VirtualTimeExecutor(start_ns=0, context=rig.context)


def test_every_node_has_the_same_time_without_a_clock_topic(rig: Any) -> None:
    """Nodes are on virtual time as soon as they are added, with no subscription for it."""
    a, b = rig.node("a"), rig.node("b")
    a.create_timer(0.25, lambda: None)
    rig.clock.step()
    assert rig.now(a) == rig.now(b) == S + 250 * MS
    assert not list(a.subscriptions)


def test_time_jumps_to_the_next_due_timer(rig: Any) -> None:
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
    rig: Any,
) -> None:
    """What the first timer publishes is delivered before the second timer fires."""
    first, second = rig.node("first"), rig.node("second")
    publisher = first.create_publisher(Int64, "count", 10)
    log: list[str] = []
    first.create_timer(0.1, lambda: publisher.publish(Int64(data=len(log))))
    second.create_subscription(Int64, "count", hear(lambda m: log.append(f"got {m.data}")), 10)
    second.create_timer(0.1, lambda: log.append("timer"))
    rig.clock.step()
    rig.clock.step()
    assert log == ["got 0", "timer", "got 2", "timer"]


def test_time_that_cannot_advance_is_reported_with_the_culprit(
    rig: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A callback that publishes to itself for ever is named instead of hanging."""
    monkeypatch.setattr(executor_module, "CALLBACKS_PER_INSTANT", 200)
    node = rig.node("a")
    echo = node.create_publisher(Int64, "echo", 10)
    node.create_subscription(Int64, "echo", echo.publish, 10)
    node.create_timer(0.1, lambda: echo.publish(Int64()))
    with pytest.raises(TimeStuckError, match=r"stuck at 1\.100 s.*Subscription /echo"):
        rig.clock.step()


def test_a_timer_without_a_period_is_reported(rig: Any) -> None:
    """It is due again at once, for ever; the others of its instant are served before."""
    node = rig.node("a")
    fired: list[str] = []
    node.create_timer(0.1, lambda: fired.append("other"))
    rig.clock.step()
    node.create_timer(0.0, lambda: None)
    with pytest.raises(
        TimeStuckError, match=r"stuck at 1\.100 s: due again .*: timer of /a, every 0"
    ):
        step_for_ever(rig.clock)
    assert fired == ["other"]


def test_a_world_that_does_not_move_is_reported(rig: Any) -> None:
    """It names an instant, is advanced to it, and names it again."""

    class Still:
        next_due_ns = 2 * S

        def advance_to(self, time_ns: int) -> None:
            pass

    rig.clock.world = Still()
    with pytest.raises(TimeStuckError, match=r"stuck at 2\.000 s: due again and again: the world"):
        step_for_ever(rig.clock)


def test_what_asks_again_for_its_own_instant_is_reported(
    rig: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where it was not a callback that asked."""
    monkeypatch.setattr(executor_module, "CALLBACKS_PER_INSTANT", 200)

    def again() -> None:
        rig.clock.call_at(rig.clock.now_ns, again)

    rig.clock.call_at(2 * S, again)
    with pytest.raises(TimeStuckError, match="schedule more for this instant"):
        step_for_ever(rig.clock)


def test_without_timers_and_world_time_cannot_move(rig: Any) -> None:
    """There is nothing to jump to, and the message says so.

    rclpy's spin would wait for a message of another process, which has no place in virtual time.
    """
    rig.node("a")
    with pytest.raises(NothingDueError, match="no timer is set"):
        rig.clock.step()
    with pytest.raises(NothingDueError):
        rig.clock.spin_until_future_complete(Future())


def test_a_timer_on_another_clock_is_refused(rig: Any) -> None:
    """A wall timer would make a run depend on the machine."""
    node = rig.node("a")
    wall = rclpy.clock.Clock(clock_type=rclpy.clock.ClockType.STEADY_TIME)
    node.create_timer(0.1, lambda: None, clock=wall)
    with pytest.raises(BtMissionError, match="STEADY_TIME clock cannot run in virtual time"):
        rig.clock.step()


def test_the_world_moves_first(rig: Any) -> None:
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

    rig.clock.world = World()
    node.create_subscription(Int64, "scan", hear(lambda m: log.append(f"scan {m.data // MS}")), 10)
    node.create_timer(0.14, lambda: log.append("timer"))
    rig.clock.step()
    rig.clock.step()
    assert log == ["scan 1070", "scan 1140", "timer"]


# ---- rclpy's ways to spin ----------------------------------------------------------------


def test_spinning_until_a_future_is_done_stops_at_its_instant(rig: Any) -> None:
    """Nothing later is served."""
    node = rig.node("a")
    gate: Future = Future()
    node.create_timer(0.25, lambda: gate.set_result(None))
    rig.clock.spin_until_future_complete(gate)
    assert rig.now(node) == S + S // 4


def test_a_timeout_is_in_virtual_time(rig: Any) -> None:
    """An hour of it passes at once, also where no timer is set."""
    node = rig.node("a")
    rig.clock.spin_until_future_complete(Future(), timeout_sec=3600.0)
    assert rig.now(node) == S + 3600 * S


def test_a_future_that_is_done_takes_no_time(rig: Any) -> None:
    """What is ready already needs no step, whatever the timeout."""
    server, node = rig.node("server"), rig.node("client")
    server.create_service(Trigger, "ask", lambda _, response: response)
    call = node.create_client(Trigger, "ask").call_async(Trigger.Request())
    rig.clock.spin_until_future_complete(call, timeout_sec=5.0)
    assert call.done()
    assert rig.now(node) == S


def test_a_callback_cannot_spin(rig: Any) -> None:
    """It would wait for what cannot come before it has returned."""
    node = rig.node("a")
    node.create_timer(0.1, lambda: rig.clock.spin_until_future_complete(Future()))
    with pytest.raises(NestedStepError, match="make it `async def`, and await the future"):
        rig.clock.step()
    assert rig.now(node) == S + S // 10


# ---- endpoints that are not discovered yet -----------------------------------------------


def test_endpoints_that_come_a_little_later_are_waited_for(
    rig: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Virtual time stands still meanwhile."""
    looks: list[int] = []

    def later(_: Sequence[Any]) -> Iterator[str]:
        looks.append(1)
        if len(looks) < 5:
            yield "publisher of /late"

    monkeypatch.setattr(discovery, "unmatched", later)
    discovery.wait_for_matching([rig.node("a")])
    assert len(looks) == 5


def test_an_action_that_no_client_can_hear_is_named_at_once(
    rig: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With both QoS; there is nothing to wait for."""
    server = rig.node("muffled")
    best_effort = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
    ActionServer(server, Turn, "turn", lambda _: None, feedback_pub_qos_profile=best_effort)
    ActionClient(rig.node("client"), Turn, "turn")
    monkeypatch.setattr(discovery, "pause", lambda _: pytest.fail("it waits"))
    words = "feedback with best effort and volatile, an action client needs reliable and volatile"
    with pytest.raises(DiscoveryError, match=f"/turn: its server /muffled publishes {words}"):
        step_for_ever(rig.clock)


def test_endpoints_that_never_come_are_named(rig: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """With what to do."""
    node = rig.node("a")
    monkeypatch.setattr(discovery, "WAIT_S", 0.0)
    monkeypatch.setattr(discovery, "unmatched", lambda _: iter(["publisher of /never"]))
    with pytest.raises(DiscoveryError, match="publisher of /never; run `bt-mission doctor`"):
        discovery.wait_for_matching([node])
