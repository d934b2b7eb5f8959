"""Messages of `/clock` that rclpy cannot use: it raises, and the process that listens ends."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bt_mission.base.dds.publishers import CLOCK


class ValidClock:
    """Mixed into a node of rclpy: a time before 0 on `/clock` is passed over."""

    def create_subscription(
        self, msg_type: Any, topic: str, callback: Callable[..., Any], *args: Any, **options: Any
    ) -> Any:
        """Subscribe, as rclpy does. rclpy follows `/clock` by a subscription of the node."""
        if topic == CLOCK:
            callback = _valid(callback)
        parent: Any = super()
        return parent.create_subscription(msg_type, topic, callback, *args, **options)


def _valid(callback: Callable[..., Any]) -> Callable[[Any], None]:
    def take(message: Any) -> None:
        if message.clock.sec >= 0:
            callback(message)

    return take
