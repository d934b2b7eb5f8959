"""Events of publishers and subscriptions, such as a QoS mismatch, for the callbacks of programs."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from rclpy.event_handler import QoSPublisherEventType, QoSSubscriptionEventType
from rclpy.node import Node

from bt_mission.ros.virtual_time import VirtualTimeExecutor

_CALLED = {
    QoSPublisherEventType.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS,
    QoSPublisherEventType.RCL_PUBLISHER_INCOMPATIBLE_TYPE,
    QoSPublisherEventType.RCL_PUBLISHER_MATCHED,
    QoSSubscriptionEventType.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS,
    QoSSubscriptionEventType.RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE,
    QoSSubscriptionEventType.RCL_SUBSCRIPTION_MATCHED,
}
"""The events of a match, or of a mismatch. The others depend on the wall clock of DDS."""


def call_event_callbacks(
    clock: VirtualTimeExecutor, nodes: Iterable[Node], say: Callable[[Node, str], None]
) -> None:
    """Have the callbacks of nodes called, at this instant, for the events of their endpoints.

    Args:
        nodes: Those of programs.
        say: Logs a line for a node, once.
    """
    for node in nodes:
        for endpoint in (*node.publishers, *node.subscriptions):
            for handler in endpoint.event_handlers:
                if handler.callback.__module__ == "rclpy.event_handler":
                    continue  # one of rclpy, which logs
                if handler.event_type not in _CALLED:
                    word = handler.event_type.name.lower().partition("_")[2].replace("_", " ")
                    text = f"the callback for '{word}' of {endpoint.topic_name} is not called here"
                    say(node, f"{text}: the event follows from the wall clock of DDS")
                elif node.executor is not None and (info := _take(handler)) is not None:
                    create_task = partial(node.executor.create_task, handler.callback, info)
                    clock.call_at(clock.now_ns, create_task)


def _take(handler: Any) -> Any:
    """Return what has happened since it was last asked for; None if nothing has."""
    handler._ready_to_take_data = True
    info = handler.take_data()
    changes = ("total_count_change", "current_count_change")
    return info if any(getattr(info, name, 0) for name in changes) else None
