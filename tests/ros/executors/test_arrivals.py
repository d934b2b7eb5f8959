"""What arrives is counted as it comes, by the middleware."""

from __future__ import annotations

import gc
import os
from pathlib import Path
from typing import Any

import pytest
from rclpy.qos import QoSProfile
from std_msgs.msg import Int64
from std_srvs.srv import Trigger

from bt_mission.ros.executors import arrivals as module
from bt_mission.ros.executors.arrivals import Arrivals


@pytest.fixture
def arrivals() -> Any:
    """Closed at the end."""
    made = Arrivals()
    yield made
    made.close()


def open_files() -> int:
    """How many files this process has open."""
    return len(list(Path("/proc/self/fd").iterdir()))


def test_messages_are_counted_until_they_are_taken(rig: Any, arrivals: Arrivals) -> None:
    """Also those from before it was watched."""
    node = rig.node("a")
    publisher = node.create_publisher(Int64, "count", 10)
    subscription = node.create_subscription(Int64, "count", lambda _: None, 10)
    rig.clock.remove_node(node)
    publisher.publish(Int64(data=1))
    assert arrivals.watch([subscription]) == []
    publisher.publish(Int64(data=2))
    (arrived,) = arrivals.waiting()
    assert (arrived.entity, arrived.count) == (subscription, 2)
    arrived.count -= 1
    assert [arrived.count for arrived in arrivals.waiting()] == [1]
    arrived.count -= 1
    assert arrivals.waiting() == []


def test_what_a_queue_has_dropped_is_not_waited_for(rig: Any) -> None:
    """Three came, one is there: nothing to take means nothing left."""
    node = rig.node("a")
    publisher = node.create_publisher(Int64, "count", 10)
    node.create_subscription(Int64, "count", lambda _: None, QoSProfile(depth=1))
    rig.clock.run_until_quiet()
    for number in range(3):
        publisher.publish(Int64(data=number))
    (arrived,) = rig.clock.arrivals.waiting()
    assert arrived.count == 3
    rig.clock.run_until_quiet()
    assert arrived.count == 0
    assert rig.clock.arrivals.waiting() == []


def test_they_come_in_the_order_in_which_they_are_watched(rig: Any, arrivals: Arrivals) -> None:
    """Whatever arrived first."""
    node = rig.node("a")
    messages = [node.create_subscription(Int64, name, lambda _: None, 10) for name in "xyz"]
    sent = [node.create_publisher(Int64, name, 10) for name in "xyz"]
    rig.clock.remove_node(node)
    arrivals.watch([messages[2], messages[0], messages[1]])
    for publisher in sent:
        publisher.publish(Int64())
    order = [messages.index(arrived.entity) for arrived in arrivals.waiting()]
    assert order == [2, 0, 1]


@pytest.mark.parametrize("how", ["watched no more", "destroyed", "closed", "forgotten"])
def test_no_file_stays_open(rig: Any, how: str) -> None:
    """And none is written to afterwards, whoever has its number by then."""
    node = rig.node("a")
    publisher = node.create_publisher(Int64, "count", 10)
    rig.clock.remove_node(node)
    gc.collect()  # what other tests have left is not closed meanwhile
    before = open_files()
    arrivals: Arrivals | None = Arrivals()
    assert arrivals is not None
    subscription = node.create_subscription(Int64, "count", lambda _: None, 10)
    service = node.create_service(Trigger, "ask", lambda _, response: response)
    arrivals.watch([subscription, service])
    assert open_files() == before + 3  # one more that asks them
    if how == "destroyed":
        node.destroy_subscription(subscription)
    if how in ("watched no more", "destroyed"):
        arrivals.watch([service])
        assert open_files() == before + 2
        arrivals.watch([])
        assert open_files() == before + 1
    if how == "forgotten":
        arrivals = None
    else:
        arrivals.close()
    assert open_files() == before
    reused = os.eventfd(0, os.EFD_NONBLOCK)
    publisher.publish(Int64())
    with pytest.raises(BlockingIOError):
        os.eventfd_read(reused)
    os.close(reused)


def test_without_the_middlewares_help_a_wait_set_is_asked(
    rig: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As where rcl has no such function."""
    monkeypatch.setattr(module, "_setter", lambda *_: None)
    messages: list[int] = []
    a, b = rig.node("a"), rig.node("b")
    b.create_subscription(Int64, "count", lambda message: messages.append(message.data), 10)
    publisher = a.create_publisher(Int64, "count", 10)

    def answer(_: Any, response: Any) -> Any:
        response.success = True
        return response

    a.create_service(Trigger, "ask", answer)
    client = b.create_client(Trigger, "ask")
    rig.clock.run_until_quiet()
    publisher.publish(Int64(data=7))
    answered = client.call_async(Trigger.Request())
    rig.clock.run_until_quiet()
    assert messages == [7]
    assert answered.done()
