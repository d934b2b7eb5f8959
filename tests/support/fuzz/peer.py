"""An action client of ours, as rclpy has it, whose peers do whatever a script says.

Only the lowest layer is replaced, that hands requests to DDS: what is answered comes by rclpy's own
``execute``, in any order, any number of times, and from whomever.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache
from typing import Any
from unittest.mock import patch

import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from bt_mission.executive.goals.goal import Goal
from bt_mission.executive.listeners import Stream
from bt_mission.ros.goal_client import RosGoalClient


@cache
def node() -> Node:
    """Return a node that nobody can discover, in a context of its own; made once."""
    context = Context()
    with patch.dict(os.environ, ROS_AUTOMATIC_DISCOVERY_RANGE="OFF"):
        rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
        return Node("fuzz", context=context, enable_rosout=False, start_parameter_services=False)


class Tasks:
    """Stands for an executor: callbacks of futures wait until it is their turn."""

    def __init__(self) -> None:
        self._waiting: list[tuple[Callable[..., Any], tuple[Any, ...]]] = []

    def create_task(self, callback: Callable[..., Any], *arguments: Any) -> None:
        """Take a callback of a future that is done."""
        self._waiting.append((callback, arguments))

    def run(self) -> None:
        """Call what waits."""
        while self._waiting:
            callback, arguments = self._waiting.pop(0)
            callback(*arguments)


class _Requests:
    """Takes requests as DDS would; remembers them."""

    def __init__(self) -> None:
        self.sent: dict[str, list[tuple[int, Any]]] = {"goal": [], "cancel": [], "result": []}
        self.is_there = True
        self._number = 0

    def _take(self, kind: str, request: Any) -> int:
        self._number += 1
        self.sent[kind].append((self._number, request))
        return self._number

    def send_goal_request(self, request: Any) -> int:
        return self._take("goal", request)

    def send_cancel_request(self, request: Any) -> int:
        return self._take("cancel", request)

    def send_result_request(self, request: Any) -> int:
        return self._take("result", request)

    def is_action_server_available(self) -> bool:
        return self.is_there

    def __enter__(self) -> None:
        pass

    def __exit__(self, *_: object) -> None:
        pass


class _Quiet:
    """A logger that says nothing: strange answers are many here."""

    def __getattr__(self, _: str) -> Callable[..., None]:
        return lambda *_args, **_options: None


class Peer(RosGoalClient):
    """The client of an action; :meth:`deliver` has something come from the other side."""

    def __init__(self, name: str, type_name: str) -> None:
        super().__init__(node(), name, type_name, lambda _: str, Stream())
        self.types = self._type
        self.requests = _Requests()
        self.tasks = Tasks()
        self.goals: dict[bytes, Goal] = {}
        self._client._client_handle = self.requests
        self._client._logger = _Quiet()

    def send(self, goal: Goal, request: Any) -> None:
        """Send it, and remember it."""
        self.goals[goal.id] = goal
        super().send(goal, request)

    def forget(self) -> None:
        """Begin anew."""
        self.goals.clear()
        self._handles.clear()
        self.requests = self._client._client_handle = _Requests()
        self.tasks = Tasks()
        for name, value in vars(self._client).items():
            if isinstance(value, dict) and name.startswith(("_goal", "_pending", "_res", "_feed")):
                value.clear()
        self._client._futures.clear()

    def deliver(self, part: str, taken: Any) -> None:
        """Have rclpy take in what somebody has sent."""
        for future in self._client._futures:
            future._set_executor(self.tasks)
        coroutine = self._client.execute({part: taken})
        try:
            coroutine.send(None)
        except StopIteration:
            return
        raise AssertionError("rclpy waits for something")
