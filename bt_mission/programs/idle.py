"""Whether programs will do anything more."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rclpy.action import ActionClient, ActionServer
from rclpy.node import Node

from bt_mission.programs.calls import Call, Program
from bt_mission.programs.waiting_requests import QUIET

_OF_EACH_NODE = ("parameters", "parameter_types", "parameters_atomically", "type_description")
"""How the services end that rclpy gives to each node."""


def is_idle(
    calls: Iterable[Call],
    programs: Mapping[Node, Program],
    only_serves: Callable[[Program], bool] | None = None,
) -> bool:
    """Return whether nothing is due for programs: no wait, no timer, no message.

    Args:
        calls: Those that have begun and not ended.
        programs: Of each node.
        only_serves: Returns whether a program that has servers has nothing to do. It keeps its
            messages for a request; so they are not due. None counts all messages.
    """
    waits = (call.wait for call in calls)
    if any(wait is None or wait.is_timed or wait.over.is_over for wait in waits):
        return False
    servers = {program for node, program in programs.items() if _serves(node)}
    return not any(
        any(map(_does_something, node.timers))
        or any(client._pending_requests for client in node.clients)
        or any(map(_awaits_answers, node.waitables))
        or (
            any(each.topic_name not in QUIET for each in node.subscriptions)
            and not (only_serves and program in servers and only_serves(program))
        )
        for node, program in programs.items()
    )


def _serves(node: Node) -> bool:
    """Return whether a node serves actions, or services of its own."""
    return any(isinstance(each, ActionServer) for each in node.waitables) or any(
        not service.srv_name.endswith(_OF_EACH_NODE) for service in node.services
    )


def _does_something(timer: Any) -> bool:
    """Return whether a timer runs, and is none of a rate on which nothing sleeps."""
    event = getattr(timer.callback, "__self__", None)
    is_unused = isinstance(event, threading.Event) and not vars(event)["_cond"]._waiters
    return not is_unused and not timer.is_canceled()


def _awaits_answers(waitable: Any) -> bool:
    """Return whether something is a client of an action that has asked for anything."""
    return isinstance(waitable, ActionClient) and bool(
        waitable._pending_goal_requests
        or waitable._pending_cancel_requests
        or waitable._pending_result_requests
    )
