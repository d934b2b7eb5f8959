"""One callback of each kind of entity: take what is ready, and call.

Each function returns the callback's coroutine if it is one, else None. Items that another receiver
has taken, or that were destroyed since they were ready, are skipped.
"""

from __future__ import annotations

import inspect
from collections import defaultdict
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from rclpy.action import ActionClient, ActionServer
from rclpy.client import Client
from rclpy.event_handler import EventHandler
from rclpy.exceptions import InvalidHandle
from rclpy.guard_condition import GuardCondition
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.timer import Timer

from bt_mission.base.errors import BtMissionError
from bt_mission.ros.executors.arrivals import Arrived
from bt_mission.ros.executors.expiry import forget_expired
from bt_mission.ros.executors.taps import ACTION_PARTS, Passing, PendingCallback, Side, Taps


class TapContext(Protocol):
    """The part of an executor that taps and futures need."""

    taps: Taps
    host: Any

    def passing(self, entity: Any, name: str, side: Side, message: Any) -> Passing:
        """Describe something on its way to an entity."""

    def actions_of(self, end: Any) -> tuple[str, ...]:
        """Return the action of a client or server, then others that rclpy confuses with it."""


def take_timer(handle: Any) -> bool:
    """Return whether the timer of a handle is due, and set it for its next time."""
    try:
        with handle:
            if not handle.is_timer_ready():  # a canceled timer is not due, either
                return False
            handle.call_timer()
    except InvalidHandle:
        return False
    return True


def call_timer(timer: Timer) -> PendingCallback:
    """Call the callback of a timer that was due."""
    callback = timer.callback
    outcome = callback()
    return None if outcome is None else rest_of(callback, outcome)


def rest_of(callback: Any, outcome: Any) -> PendingCallback:
    """Return what is still to be awaited of a callback that has returned something."""
    return outcome if _is_to_be_awaited(callback, outcome) else None


def _is_to_be_awaited(callback: Any, outcome: Any) -> bool:
    """Return whether to await a result: as in rclpy, only that of an ``async def``."""
    return inspect.iscoroutine(outcome) and inspect.iscoroutinefunction(callback)


def _serve_subscription(arrived: Arrived, executor: TapContext) -> PendingCallback:
    subscription, handle = arrived.entity, arrived.handle
    try:
        with handle:
            taken = handle.take_message(subscription.msg_type, subscription.raw)
    except InvalidHandle:
        return None
    if taken is None:
        arrived.count = 0
        return None
    message, *about = taken
    if subscription._callback_type is Subscription.CallbackType.MessageOnly:
        about = []
    if executor.taps.is_open and _catch_message(subscription, message, about, executor):
        return None
    callback = subscription._callback
    outcome = callback(message, *about)
    return None if outcome is None else rest_of(callback, outcome)


def _catch_message(
    subscription: Subscription, message: Any, about: list[Any], executor: TapContext
) -> bool:
    """Pass a message through the taps of its topic; raw bytes are unpacked for the taps."""
    name = subscription.topic_name
    if not executor.taps.has(name, Side.MESSAGE):
        return False
    raw = subscription.raw
    if raw:
        message = deserialize_message(message, subscription.msg_type)

    def deliver(changed: Any) -> PendingCallback:
        changed = serialize_message(changed) if raw else changed
        return rest_of(subscription.callback, subscription.callback(changed, *about))

    passing = executor.passing(subscription, name, Side.MESSAGE, message)
    return executor.taps.catch(subscription, passing, deliver)


def _serve_service(arrived: Arrived, executor: TapContext) -> PendingCallback:
    service = arrived.entity
    handle = service.handle
    try:
        with handle:
            request, header = handle.service_take_request(service.srv_type.Request)
    except InvalidHandle:
        return None
    if header is None:
        return None

    def deliver(asked: Any) -> PendingCallback:
        response = service.callback(asked, service.srv_type.Response())
        if not _is_to_be_awaited(service.callback, response):
            service.send_response(response, header)
            return None
        rest: Any = response

        async def answer() -> None:
            service.send_response(await rest, header)

        return answer()

    if executor.taps.is_open:
        passing = executor.passing(service, service.service_name, Side.REQUEST, request)
        caught = executor.taps.catch(
            service, passing, deliver, lambda response: service.send_response(response, header)
        )
        if caught:
            return None
    return deliver(request)


def _serve_client(arrived: Arrived, executor: TapContext) -> PendingCallback:
    client = arrived.entity
    handle = client.handle
    try:
        with handle:
            header, response = handle.take_response(client.srv_type.Response)
    except InvalidHandle:
        return None
    if header is None:
        return None

    def deliver(answer: Any) -> None:
        try:
            future = client.get_pending_request(header.request_id.sequence_number)
        except KeyError:
            return  # the caller does not wait for the answer any more
        future._set_executor(executor)
        future.set_result(answer)

    if executor.taps.is_open:
        passing = executor.passing(client, client.service_name, Side.RESPONSE, response)
        if executor.taps.catch(client, passing, deliver):
            return None
    deliver(response)
    return None


def _serve_guard(arrived: Arrived, _: TapContext) -> PendingCallback:
    guard = arrived.entity
    return rest_of(guard.callback, guard.callback())


def _serve_waitable(arrived: Arrived, executor: TapContext) -> PendingCallback:
    """Serve an action client or server, or a waitable of somebody else's."""
    waitable = arrived.entity
    host = executor.host
    data = _take_parts(arrived, one_by_one=host is not None and host.owns(waitable))
    if host is not None:
        host.took(waitable, data)
    for future in waitable._futures:
        if future._executor() is not executor:
            future._set_executor(executor)
    if executor.taps.is_open and isinstance(waitable, ActionClient | ActionServer):
        data = _sift(waitable, data, executor)
    return waitable.execute(data)


def _take_parts(arrived: Arrived, *, one_by_one: bool) -> Any:
    """Take the ready parts of a waitable; of an action, one item of each part.

    Args:
        one_by_one: Take one part for a client, in the order in which they come on a robot. What the
            answer to a goal calls is then over before the first feedback.
    """
    waitable = arrived.entity
    if arrived.file is None:
        return waitable.take_data()  # a wait set has reported what is ready
    if isinstance(waitable, ActionClient):
        return (_take_answer if one_by_one else _take_answers)(waitable, arrived)
    if isinstance(waitable, EventHandler):
        waitable._ready_to_take_data = True
        arrived.count = 0  # it reports all events at once
        return waitable.take_data()
    forget_expired(waitable)
    waitable._is_goal_request_ready = waitable._is_cancel_request_ready = True
    waitable._is_result_request_ready = True
    waitable._is_goal_expired = False
    data = waitable.take_data()
    arrived.count -= max(len(data.keys() & ACTION_PARTS.keys()) - 1, 0)
    return data


def _take_answers(client: Any, arrived: Arrived) -> dict[str, Any]:
    """Take one item of each part, and stop once everything counted is taken."""
    data: dict[str, Any] = {}
    for flags in _ANSWERS:
        client.__dict__.update(flags)
        data |= client.take_data()
        if len(data) > arrived.count:
            break
    arrived.count -= max(len(data) - 1, 0)
    return data


def _take_answer(client: Any, arrived: Arrived) -> dict[str, Any]:
    """Take the first part of which there is an item."""
    pending = {
        "goal_response": client._pending_goal_requests,
        "cancel_response": client._pending_cancel_requests,
        "feedback": True,
        "result_response": client._pending_result_requests,
    }
    for part, is_awaited in pending.items():
        if is_awaited:
            client.__dict__.update(_FLAGS[part])
            if data := client.take_data():
                return dict(data)
    return _take_answers(client, arrived)


def _sift(end: Any, data: dict[str, Any], executor: TapContext) -> dict[str, Any]:
    """Pass what one end of an action has taken through the taps.

    Return what none of them caught.
    """
    action, *others = executor.actions_of(end)
    if others and any(executor.taps.are_at(name) for name in (action, *others)):
        raise BtMissionError(
            f"{action} and {', '.join(others)} have one type and one node, where rclpy cannot "
            f"distinguish them: serve them from separate nodes to tap them",
            code="BT-914",
        )
    return {
        part: data[part]
        for part in (*ACTION_PARTS, "expired")
        if part in data
        and (part == "expired" or not _catch_part(end, action, part, data[part], executor))
    }


def _catch_part(end: Any, action: str, part: str, taken: Any, executor: TapContext) -> bool:
    name = f"{action}/_action/{ACTION_PARTS[part]}"
    if part in ("feedback", "status"):
        passing = executor.passing(end, name, Side.MESSAGE, taken)
        return executor.taps.catch(end, passing, lambda m: end.execute({part: m}))
    header, message = taken

    def deliver(changed: Any) -> PendingCallback:
        return end.execute({part: (header, changed)})

    if isinstance(end, ActionClient):
        passing = executor.passing(end, name, Side.RESPONSE, message)
        return executor.taps.catch(end, passing, deliver)

    def answer(response: Any) -> None:
        getattr(end._handle, _SENDERS[part])(header, response)

    passing = executor.passing(end, name, Side.REQUEST, message)
    return executor.taps.catch(end, passing, deliver, answer)


_READY = ("feedback", "status", "goal_response", "cancel_response", "result_response")
_FLAGS = {part: {f"_is_{known}_ready": known == part for known in _READY} for part in _READY}
_ANSWERS = tuple(_FLAGS.values())
"""The attributes of an action client that select the part to take. Most arrivals are feedback."""

_SENDERS = {
    "goal": "send_goal_response",
    "cancel": "send_cancel_response",
    "result": "send_result_response",
}
SERVERS: Mapping[type, Callable[[Arrived, TapContext], PendingCallback]] = defaultdict(
    lambda: _serve_waitable,
    {
        Subscription: _serve_subscription,
        Service: _serve_service,
        Client: _serve_client,
        GuardCondition: _serve_guard,
    },
)
"""The function that serves a ready entity, by its class."""
