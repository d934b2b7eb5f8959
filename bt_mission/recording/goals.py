"""Requests to actions and their answers, as the service events of ROS's own introspection.

rosbag2 records services as topics ``SERVICE/_service_event`` of the type ``SERVICE_TYPE_Event``.
The three services of an action are recorded so, as the client of the mission sees them: a request
when it is sent, an answer when it has come. The event of an answer holds its request, too, because
the answers of actions do not say which goal they are about.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

from action_msgs.srv import CancelGoal
from builtin_interfaces.msg import Time
from rclpy.serialization import serialize_message
from service_msgs.msg import ServiceEventInfo

from bt_mission.ros.goal_client import Exchange
from bt_mission.ros.interface_types import action_type

OpenChannel = Callable[[str, str], Callable[[bytes], None]]
"""Called with a topic and its type; returns the receiver of its messages."""


class GoalEvents:
    """Turns exchanges of action clients into messages of channels.

    Args:
        open_channel: Makes the channel of a topic when it is first needed.
        now: The time of an event.
    """

    def __init__(self, open_channel: OpenChannel, now: Callable[[], Time]) -> None:
        self._open_channel = open_channel
        self._now = now
        self._channels: dict[str, Callable[[bytes], None]] = {}
        self._sent: Counter[str] = Counter()
        self._sequence: dict[tuple[str, bytes], int] = {}
        self._open: dict[bytes, str] = {}
        self._ended: set[str] = set()

    @property
    def busy(self) -> set[str]:
        """The actions that have a goal of the mission, or had one just before."""
        return {*self._open.values(), *self._ended}

    def take_busy(self) -> set[str]:
        """The actions that have had a goal of the mission since the last call."""
        busy = self.busy
        self._ended.clear()
        return busy

    def take(self, exchange: Exchange) -> None:
        """Record a request or its response."""
        self._follow(exchange)
        service = f"{exchange.action}/_action/{exchange.service}"
        type_name, event_class = _event_type(exchange)
        event = event_class(request=[exchange.request])
        event.info.stamp = self._now()
        if exchange.answer is None:
            self._sent[service] += 1
            self._sequence[service, exchange.goal_id] = self._sent[service]
            event.info.event_type = ServiceEventInfo.REQUEST_SENT
        else:
            event.info.event_type = ServiceEventInfo.RESPONSE_RECEIVED
            event.response = [exchange.answer]
        event.info.sequence_number = self._sequence.get((service, exchange.goal_id), 0)
        if service not in self._channels:
            topic = f"{service}/_service_event"
            self._channels[service] = self._open_channel(topic, type_name)
        self._channels[service](serialize_message(event))

    def _follow(self, exchange: Exchange) -> None:
        if exchange.answer is None:
            self._open[exchange.goal_id] = exchange.action
        elif exchange.service == "get_result" or (
            exchange.service == "send_goal" and not exchange.answer.accepted
        ):
            self._open.pop(exchange.goal_id, None)
            self._ended.add(exchange.action)


def _event_type(exchange: Exchange) -> tuple[str, Any]:
    if exchange.service == "cancel_goal":
        return "action_msgs/srv/CancelGoal_Event", CancelGoal.Event
    kind = action_type(exchange.type_name).Impl
    if exchange.service == "send_goal":
        return f"{exchange.type_name}_SendGoal_Event", kind.SendGoalService.Event
    return f"{exchange.type_name}_GetResult_Event", kind.GetResultService.Event
