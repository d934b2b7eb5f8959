"""Of a node that was destroyed nothing is left in the executor."""

from __future__ import annotations

import gc
import weakref
from typing import Any

import pytest
from bt_mission_interfaces.action import Turn
from rclpy.action import ActionClient, ActionServer
from rclpy.node import Node
from std_msgs.msg import Int64
from std_srvs.srv import Trigger

from bt_mission.ros.graph import destroy_actions

S = 1_000_000_000
KINDS = ("subscriptions", "services", "clients", "guards", "waitables", "timers")


def furnish(node: Node) -> list[Any]:
    """Give a node one of everything; gives what it has."""
    ActionServer(node, Turn, "turn", lambda handle: Turn.Result())
    ActionClient(node, Turn, "turn")
    return [
        node.create_publisher(Int64, "count", 10),
        node.create_subscription(Int64, "count", lambda _: None, 10),
        node.create_service(Trigger, "ask", lambda _, response: response),
        node.create_client(Trigger, "ask"),
        node.create_guard_condition(lambda: None),
        node.create_timer(0.1, lambda: None),
        *node.waitables,
    ]


def left_in(executor: Any) -> dict[str, int]:
    """How many entities of each kind the executor waits for, besides each node's own service."""
    counts = {kind: len(getattr(executor._entities, kind)) for kind in KINDS}
    counts["services"] -= len(executor.get_nodes())
    return {kind: count for kind, count in counts.items() if count}


@pytest.mark.parametrize("where", ["outside", "in a callback"])
def test_a_destroyed_node_leaves_nothing_in_the_wait_set(rig: Any, where: str) -> None:
    """Its actions included, which rclpy does not destroy with it."""
    node, other = rig.node("a"), rig.node("b")
    furnish(node)
    other.create_timer(1.0, lambda: None)
    rig.clock.step()
    if where == "outside":
        node.destroy_node()
    else:
        node.create_timer(0.05, node.destroy_node)
        rig.clock.step()
    rig.clock.step()
    assert left_in(rig.clock) == {"timers": 1}
    assert rig.clock.get_nodes() == [other]
    destroy_actions(node)


def test_a_destroyed_node_does_not_stop_time(rig: Any) -> None:
    """The others are served as before, while its actions are still there."""
    node, other = rig.node("a"), rig.node("b")
    furnish(node)
    ActionClient(other, Turn, "turn")
    fired: list[int] = []
    other.create_timer(0.5, lambda: fired.append(rig.now(other)))
    node.create_timer(0.7, node.destroy_node)
    rig.steps_until(3 * S)
    assert fired == [S + n * S // 2 for n in (1, 2, 3, 4)]
    destroy_actions(node)


def test_nothing_of_a_destroyed_node_is_kept_alive(rig: Any) -> None:
    """Neither the node nor any entity of it."""
    other = rig.node("b")
    other.create_timer(1.0, lambda: None)
    node = Node("a", context=rig.context, enable_rosout=False, start_parameter_services=False)
    rig.clock.add_node(node)
    kept = [weakref.ref(made) for made in (node, *furnish(node))]
    rig.clock.step()
    destroy_actions(node)
    node.destroy_node()
    del node
    rig.clock.step()
    gc.collect()
    assert [reference() for reference in kept if reference() is not None] == []


def test_an_executor_that_is_shut_down_lets_go_of_its_nodes(rig: Any) -> None:
    """Its wait set holds nothing of theirs."""
    furnish(rig.node("a"))
    rig.clock.step()
    rig.clock.shutdown()
    assert left_in(rig.clock) == {}


def test_a_node_removed_by_a_timer_fires_no_timer_of_that_instant(rig: Any) -> None:
    """Removal takes effect at once."""
    first, second = rig.node("first"), rig.node("second")
    fired: list[str] = []
    first.create_timer(0.1, lambda: rig.clock.remove_node(second))
    second.create_timer(0.1, lambda: fired.append("second"))
    rig.clock.step()
    assert fired == []
