"""The ROS log of programs: its lines are among those that they print, with virtual time."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from contextlib import suppress
from functools import cache, partial
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.logging import LoggingSeverity

from bt_mission.base.code_owner import owner_of
from bt_mission.programs.calls import current_call


class RclpyOfLogs:
    """rclpy's compiled module, as the loggers of ``rclpy`` see it."""

    def __getattr__(self, name: str) -> Any:
        """Return the rest as it is."""
        return getattr(_rclpy, name)

    def rclpy_logging_rcutils_log(
        self, level: Any, name: str, text: str, function: str, file: str, line: int
    ) -> None:
        """Log a line. One of a program is printed as the others of it, not by ROS."""
        call = current_call()
        output = None if call is None else getattr(call.program, "output", None)
        log = partial(_rclpy.rclpy_logging_rcutils_log, level, name, text, function, file, line)
        if output is None or owner_of(file) == "ours":
            log()
            return
        _without_terminal(log)
        output.write(f"[{LoggingSeverity(level).name}] [{name}]: {text}\n")


def _without_terminal(log: Callable[[], None]) -> None:
    """Log what goes to ``/rosout`` alone."""
    handlers = _handlers()
    if handlers is None:
        log()
        return
    rcutils, rosout = handlers
    former = rcutils.rcutils_logging_get_output_handler()
    rcutils.rcutils_logging_set_output_handler(rosout)
    try:
        log()
    finally:
        rcutils.rcutils_logging_set_output_handler(former)


@cache
def _handlers() -> tuple[Any, ctypes.c_void_p] | None:
    """Return the library of the log, and the function that sends to ``/rosout``; None without."""
    with suppress(OSError, AttributeError):
        rcutils, rcl = ctypes.CDLL("librcutils.so"), ctypes.CDLL("librcl.so")
        rcutils.rcutils_logging_get_output_handler.restype = ctypes.c_void_p
        rcutils.rcutils_logging_set_output_handler.argtypes = [ctypes.c_void_p]
        rcutils.rcutils_logging_set_output_handler.restype = None
        return rcutils, ctypes.cast(rcl.rcl_logging_rosout_output_handler, ctypes.c_void_p)
    return None
