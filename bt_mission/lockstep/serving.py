"""One callback of each kind of entity: take what is ready, and call.

Each function gives the callback's coroutine where it is one, and None otherwise. What was taken
by somebody else, or destroyed since it was found ready, is nothing to serve.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Coroutine
from typing import TYPE_CHECKING, Any

from rclpy.client import Client
from rclpy.exceptions import InvalidHandle
from rclpy.guard_condition import GuardCondition
from rclpy.service import Service
from rclpy.subscription import Subscription

if TYPE_CHECKING:
    from rclpy.executors import Executor
    from rclpy.timer import Timer
    from rclpy.waitable import Waitable

Rest = Coroutine[Any, Any, None] | None
"""What is left to run of a callback."""


def serve(entity: Any, executor: Executor) -> Rest:
    """Serve an entity that was found ready."""
    return _SERVERS.get(type(entity), _serve_waitable)(entity, executor)


def serve_timer(timer: Timer) -> tuple[bool, Rest]:
    """Call a timer if it is due; gives whether it was."""
    handle = timer.handle
    try:
        with handle:
            if handle.is_timer_canceled() or not handle.is_timer_ready():
                return False, None
            handle.call_timer()
    except InvalidHandle:
        return False, None
    return True, _rest(timer.callback())


def _rest(outcome: Any) -> Rest:
    return outcome if inspect.iscoroutine(outcome) else None


def _serve_subscription(subscription: Subscription, _: Executor) -> Rest:
    handle = subscription.handle
    try:
        with handle:
            taken = handle.take_message(subscription.msg_type, subscription.raw)
    except InvalidHandle:
        return None
    if taken is None:
        return None
    if subscription._callback_type is Subscription.CallbackType.MessageOnly:
        taken = taken[:1]
    return _rest(subscription.callback(*taken))


def _serve_service(service: Service, _: Executor) -> Rest:
    handle = service.handle
    try:
        with handle:
            request, header = handle.service_take_request(service.srv_type.Request)
    except InvalidHandle:
        return None
    if header is None:
        return None
    response = service.callback(request, service.srv_type.Response())
    if not inspect.iscoroutine(response):
        service.send_response(response, header)
        return None

    async def answer() -> None:
        service.send_response(await response, header)

    return answer()


def _serve_client(client: Client, executor: Executor) -> Rest:
    handle = client.handle
    try:
        with handle:
            header, response = handle.take_response(client.srv_type.Response)
    except InvalidHandle:
        return None
    if header is None:
        return None
    try:
        future = client.get_pending_request(header.request_id.sequence_number)
    except KeyError:
        return None  # the caller no longer wants the answer
    future._set_executor(executor)
    future.set_result(response)
    return None


def _serve_guard(guard: GuardCondition, _: Executor) -> Rest:
    return _rest(guard.callback())


def _serve_waitable(waitable: Waitable, executor: Executor) -> Rest:
    data = waitable.take_data()
    for future in waitable._futures:
        future._set_executor(executor)
    return waitable.execute(data)


_SERVERS: dict[type, Callable[[Any, Executor], Rest]] = {
    Subscription: _serve_subscription,
    Service: _serve_service,
    Client: _serve_client,
    GuardCondition: _serve_guard,
}
