"""The ROS log of programs: its lines are among those that they print, with virtual time."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from contextlib import suppress
from functools import cache, partial
from typing import Any

from rclpy.clock import Clock
from rclpy.impl import rcutils_logger
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.logging import LoggingSeverity
from rclpy.time import Time
from typing_extensions import override

from bt_mission.base.code_owner import owner_of
from bt_mission.programs.calls import current_call

_LONG_AGO_NS = 1 << 60
"""What virtual time counts from for lines that are throttled: the first one is always due."""


_CLOCK = "throttle_time_source_type"
_real_clock = rcutils_logger.Throttle.params[_CLOCK]


class _PresentClock(Clock):
    """The clock with which rclpy throttles lines of a log: virtual in the code of programs.

    It equals that of rclpy, since the log refuses another clock for the same line.
    """

    def __eq__(self, other: object) -> bool:
        """Return whether lines are throttled by the same clock."""
        return other is self or other is _real_clock

    def __hash__(self) -> int:
        """Return that of rclpy's clock."""
        return hash(_real_clock)

    @override
    def now(self) -> Time:
        call = current_call()
        if call is None:
            return super().now()
        now_ns = call.program.host.clock.now_ns
        return Time(nanoseconds=_LONG_AGO_NS + now_ns, clock_type=self.clock_type)


class Throttle(rcutils_logger.Throttle):
    """``throttle_duration_sec`` of the log."""

    params = {**rcutils_logger.Throttle.params, _CLOCK: _PresentClock()}  # noqa: RUF012 - of rclpy


FILTERS = {**rcutils_logger.supported_filters, "throttle": Throttle}
"""The filters of the log of rclpy, by name."""


class RclpyOfLogs:
    """rclpy's compiled module, as the loggers of ``rclpy`` see it.

    The levels of loggers are those of the process: each whole program has its own.
    """

    def __getattr__(self, name: str) -> Any:
        """Return the rest as it is."""
        return getattr(_rclpy, name)

    def rclpy_logging_set_logger_level(self, name: str, level: Any, *options: Any) -> None:
        """Set the level of a logger and of those below it; 0 takes it back."""
        levels = _levels()
        if levels is None:
            _rclpy.rclpy_logging_set_logger_level(name, level, *options)
        else:
            levels[name] = int(level)

    def rclpy_logging_get_logger_effective_level(self, name: str) -> Any:
        """Return the level of a logger, or of the nearest above it that has one."""
        levels = _levels()
        real = _rclpy.rclpy_logging_get_logger_effective_level(name)
        if levels is None:
            return real
        above = name
        while above:
            if levels.get(above):
                return levels[above]
            above = above.rpartition(".")[0]
        return levels.get("") or real

    def rclpy_logging_logger_is_enabled_for(self, name: str, level: Any) -> bool:
        """Return whether a logger logs lines of a level."""
        return int(level) >= int(self.rclpy_logging_get_logger_effective_level(name))

    def rclpy_logging_rcutils_log(
        self, level: Any, name: str, text: str, function: str, file: str, line: int
    ) -> None:
        """Log a line. One of a program is printed as the others of it, not by ROS."""
        call = current_call()
        output = None if call is None else getattr(call.program, "output", None)
        real: Callable[..., None] = _rclpy.rclpy_logging_rcutils_log
        log = partial(real, level, name, text, function, file, line)
        if output is None or owner_of(file) == "ours":
            log()
            return
        _without_terminal(partial(_at_level, level, name, log))
        output.write(f"[{LoggingSeverity(level).name}] [{name}]: {text}\n")


def _levels() -> dict[str, int] | None:
    """Return the levels of the loggers of the program whose code runs; None without one."""
    call = current_call()
    return None if call is None else getattr(call.program, "log_levels", None)


def _at_level(level: Any, name: str, log: Callable[[], None]) -> None:
    """Log a line also where the process would not."""
    if _rclpy.rclpy_logging_logger_is_enabled_for(name, level):
        log()
        return
    _rclpy.rclpy_logging_set_logger_level(name, level)
    try:
        log()
    finally:
        _rclpy.rclpy_logging_set_logger_level(name, LoggingSeverity.UNSET)


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
