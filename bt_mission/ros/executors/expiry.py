"""The results of an action server that are old enough to be dropped.

rcl has a timer for the oldest result of each server. rclpy's executors find it in their wait set;
it has no other name in Python. Here it is looked up once, through a wait set, and then asked.
"""

from __future__ import annotations

import ctypes
from contextlib import suppress
from weakref import WeakKeyDictionary

from rclpy.action import ActionServer
from rclpy.exceptions import InvalidHandle
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy


class _WaitSet(ctypes.Structure):
    """The beginning of ``rcl_wait_set_t``."""

    _fields_ = [
        ("subscriptions", ctypes.POINTER(ctypes.c_void_p)),
        ("size_of_subscriptions", ctypes.c_size_t),
        ("guard_conditions", ctypes.POINTER(ctypes.c_void_p)),
        ("size_of_guard_conditions", ctypes.c_size_t),
        ("timers", ctypes.POINTER(ctypes.c_void_p)),
        ("size_of_timers", ctypes.c_size_t),
    ]


_timers: WeakKeyDictionary[ActionServer, int] = WeakKeyDictionary()
"""The addresses of the timers, which live as long as their servers."""

_until_next_call = ctypes.CDLL("librcl.so").rcl_timer_get_time_until_next_call
_until_next_call.argtypes = [ctypes.c_void_p, ctypes.POINTER(ctypes.c_int64)]


def ns_until_expiry(server: ActionServer) -> int | None:
    """Return the time until a result expires, ns of the clock of the server's node, or None."""
    if not server._goal_handles:
        return None
    wait_ns = ctypes.c_int64()
    try:
        with server._handle:
            timer = _timers.get(server) or _timer_of(server)
            is_canceled = _until_next_call(timer, ctypes.byref(wait_ns)) != 0
    except InvalidHandle:
        return None
    return None if is_canceled else wait_ns.value


def forget_expired(server: ActionServer) -> bool:
    """Drop the results that have expired. Return whether there may have been one."""
    wait_ns = ns_until_expiry(server)
    if wait_ns is None or wait_ns > 0:
        return False
    server._is_goal_request_ready = server._is_cancel_request_ready = False
    server._is_result_request_ready = False
    server._is_goal_expired = True
    with suppress(StopIteration):
        server.execute(server.take_data()).send(None)
    return True


def _timer_of(server: ActionServer) -> int:
    numbers = server.get_num_entities()
    context = server._node.context.handle
    with context:
        wait_set = _rclpy.WaitSet(
            numbers.num_subscriptions,
            numbers.num_guard_conditions,
            numbers.num_timers,
            numbers.num_clients,
            numbers.num_services,
            numbers.num_events,
            context,
        )
    wait_set.clear_entities()
    server.add_to_wait_set(wait_set)
    timer: int = _WaitSet.from_address(wait_set.pointer).timers[0]
    _timers[server] = timer
    return timer
