"""rclpy's ways to spin take virtual time."""

from __future__ import annotations

from typing import Any

import pytest
from rclpy.task import Future
from std_srvs.srv import Trigger

from bt_mission.virtual_time import NestedStepError, NothingDueError

S = 1_000_000_000


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


def test_spinning_with_nothing_due_is_an_error(rig: Any) -> None:
    """Rclpy's would wait for a message of another process, which has no place in virtual time."""
    rig.node("a")
    with pytest.raises(NothingDueError):
        rig.clock.spin_until_future_complete(Future())


def test_a_callback_cannot_spin(rig: Any) -> None:
    """It would wait for what cannot come before it has returned."""
    node = rig.node("a")
    node.create_timer(0.1, lambda: rig.clock.spin_until_future_complete(Future()))
    with pytest.raises(NestedStepError, match="make it `async def`, and await the future"):
        rig.clock.step()
    assert rig.now(node) == S + S // 10
