"""What action servers log when they reject a goal: the response has no reason."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from weakref import WeakSet

from rcl_interfaces.msg import Log
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from bt_mission.base.dds.endpoints import UNNAMED, node_of

ROSOUT = "/rosout"
ROSOUT_DEPTH = 50

FEEDBACK = "/_action/feedback"
"""A publisher of this topic of an action serves the action."""


@dataclass(eq=False)
class _Listener:
    """What the servers of an action have logged since a goal was sent.

    Attributes:
        action: The resolved name.
        loggers: The names of the servers' loggers; none while they are not known.
        warning: Their newest warning or error; `line` is the newest other line.
    """

    action: str
    loggers: frozenset[str] = frozenset()
    warning: str = ""
    line: str = ""

    @property
    def reason(self) -> str:
        """The reason of a rejection, as far as it is logged."""
        return self.warning or (f"logged '{self.line}'" if self.line else "")


class ServerLogs:
    """Receives on ``/rosout`` what servers log.

    Args:
        node: Owns the subscription.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._listeners: WeakSet[_Listener] = WeakSet()
        """Each is kept by its reader, and so by its goal."""
        self._subscription: Subscription | None = None

    def begin(self) -> None:
        """Subscribe; further calls do nothing."""
        if self._subscription is None:
            self._subscription = self._node.create_subscription(
                Log, ROSOUT, self._take, QoSProfile(depth=ROSOUT_DEPTH)
            )

    def close(self) -> None:
        """Subscribe no more."""
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None

    def listen(self, action: str) -> Callable[[], str]:
        """Return a reader of what the servers of an action log from now on; empty without a line.

        Args:
            action: The resolved name.
        """
        self.begin()
        listener = _Listener(action)
        self._listeners.add(listener)
        return lambda: listener.reason

    def _take(self, message: Any) -> None:
        for listener in self._listeners:
            listener.loggers = listener.loggers or self._loggers(listener.action)
            if any(_is_of(message.name, server) for server in listener.loggers):
                if message.level >= Log.WARN:
                    listener.warning = message.msg
                elif message.level >= Log.INFO:
                    listener.line = message.msg

    def _loggers(self, action: str) -> frozenset[str]:
        """The names of loggers of the nodes that serve an action; none if one is not known yet."""
        names = set(map(node_of, self._node.get_publishers_info_by_topic(action + FEEDBACK)))
        return frozenset(
            () if UNNAMED in names else (name.strip("/").replace("/", ".") for name in names)
        )


def _is_of(logger: str, server: str) -> bool:
    return logger == server or logger.startswith(f"{server}.")
