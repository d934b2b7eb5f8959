"""The clocks that a program reads, and the ways to wait for them."""

from __future__ import annotations

import datetime
import selectors
import time
from collections.abc import Callable
from typing import Any

from rclpy.clock_type import ClockType
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy

from bt_mission.base.stamps import NS
from bt_mission.programs.calls import Call, CallWait, StandIn, current_call

_real_sleep = time.sleep


def sleep(seconds: float) -> None:
    """Replace ``time.sleep``."""
    call = current_call()
    if call is None:
        _real_sleep(seconds)
        return
    if seconds < 0:
        raise ValueError("sleep length must be non-negative")
    sleep_ns(call, round(seconds * NS))


def take_round() -> None:
    """Replace :func:`bt_mission.base.user_loops.take_round`."""
    call = current_call()
    if call is not None:
        call.program.host.take_time(call)


def sleep_ns(call: Call, nanoseconds: int) -> None:
    """Sleep for virtual time; for none, let others run."""
    host = call.program.host
    if nanoseconds <= 0:
        host.take_time(call)
        wait = CallWait("gives way", is_timed=True)
        wait.over.set_result(None)
        call.park(wait)
        return
    host.wait(CallWait("sleeps", is_timed=True), nanoseconds)


def _reader(real: Callable[[], Any], *, in_ns: bool) -> Callable[[], Any]:
    def read() -> Any:
        call = current_call()
        if call is None:
            return real()
        now_ns = call.program.host.take_time(call)
        return now_ns if in_ns else now_ns / NS

    return read


READERS: dict[str, Any] = {
    f"{name}{suffix}": _reader(getattr(time, f"{name}{suffix}"), in_ns=bool(suffix))
    for name in ("time", "monotonic", "perf_counter")
    for suffix in ("", "_ns")
}
"""The functions of ``time`` that read a clock, by name."""


def _at_present(real: Callable[..., Any], position: int) -> Callable[..., Any]:
    """Return a function of ``time`` whose argument is, without one, the present."""

    def of_now(*args: Any) -> Any:
        call = current_call()
        if call is None or len(args) > position:
            return real(*args)
        now_s = call.program.host.take_time(call) / NS
        return real(*args, now_s if position == 0 else time.localtime(now_s))

    return of_now


CALENDAR: dict[str, Any] = {
    "localtime": _at_present(time.localtime, 0),
    "gmtime": _at_present(time.gmtime, 0),
    "ctime": _at_present(time.ctime, 0),
    "strftime": _at_present(time.strftime, 1),
}


_real_datetime = datetime.datetime
_RealSelector = selectors.DefaultSelector


class Datetime(_real_datetime, metaclass=StandIn):
    """``datetime.datetime``, whose present is virtual."""

    _stands_for = _real_datetime

    @classmethod
    def now(cls, tz: datetime.tzinfo | None = None) -> Any:
        """Return the present."""
        call = current_call()
        if call is None:
            return _real_datetime.now(tz)
        return _real_datetime.fromtimestamp(call.program.host.take_time(call) / NS, tz)

    @classmethod
    def today(cls) -> Any:
        """Return the present, in local time."""
        return cls.now()

    @classmethod
    def utcnow(cls) -> Any:
        """Return the present in UTC, without a time zone."""
        return cls.now(datetime.UTC).replace(tzinfo=None)


class ProgramSelector(_RealSelector, metaclass=StandIn):
    """``selectors.DefaultSelector``, with which ``asyncio`` waits for times and for its threads.

    Its files are real; what they get is seen when code of programs has run.
    """

    _stands_for = _RealSelector

    def select(self, timeout: float | None = None) -> Any:
        """Return which files are ready, or wait for one, or a time."""
        call = current_call()
        if call is None:
            return super().select(timeout)
        ready = super().select(0)
        if ready:
            return ready
        if timeout is not None and timeout <= 0:
            sleep_ns(call, 0)
            return super().select(0)
        wait = CallWait("waits in an event loop", is_timed=timeout is not None)
        host = call.program.host
        host.polls[wait] = lambda: bool(_RealSelector.select(self, 0))
        try:
            host.wait(wait, None if timeout is None else round(timeout * NS))
        finally:
            del host.polls[wait]
        return super().select(0)


# ---- clocks of rclpy --------------------------------------------------------------------------


class ClockHandle(_rclpy.Clock):  # type: ignore[misc]  # compiled
    """A clock of rclpy that shows virtual time, whatever its kind."""

    def __init__(self, program: Any) -> None:
        super().__init__(ClockType.ROS_TIME)
        self._host = program.host
        super().set_ros_time_override_is_enabled(True)
        self._show(self._host.clock.now_ns)

    def _show(self, time_ns: int) -> None:
        super().set_ros_time_override(_rclpy.rcl_time_point_t(time_ns, ClockType.ROS_TIME))

    def set_ros_time_override_is_enabled(self, enabled: bool) -> None:  # noqa: FBT001 - of rclpy
        """Stay on virtual time (rclpy would follow ``use_sim_time``)."""

    def get_now(self) -> Any:
        """Return the time; one that no node keeps is set first."""
        call = current_call()
        if call is not None:
            self._host.take_time(call)
        if not self._host.clock.clocks.keeps(self):
            self._show(self._host.clock.now_ns)
        return super().get_now()


class ClockEvent:
    """``rclpy``'s event on which clocks sleep."""

    def __init__(self) -> None:
        self._wait = CallWait("sleeps on a clock", is_timed=True)

    def set(self) -> None:
        """End the sleep."""
        self._wait.over.set_result(True)

    def _wait_until(self, clock: Any, until: Any) -> None:
        call = current_call()
        assert call is not None, "made in the code of a program"
        left_ns = until.nanoseconds - clock.get_now().nanoseconds
        if left_ns > 0 and not self._wait.over.is_over:
            call.program.host.wait(self._wait, left_ns)

    wait_until_system = wait_until_steady = _wait_until

    def wait_until_ros(self, clock: Any, until: Any) -> None:
        """Sleep; say what would happen on a robot whose ROS time is simulated."""
        call = current_call()
        if call is not None and call.spin is not None and not call.spin.executor.hands_over:
            call.program.host.remark_on_sleep(call)
        self._wait_until(clock, until)


class RclpyOfClocks:
    """rclpy's compiled module, as ``rclpy.clock`` sees it in a program."""

    def __getattr__(self, name: str) -> Any:
        """Return the rest as it is."""
        return getattr(_rclpy, name)

    @property
    def ClockEvent(self) -> Any:  # noqa: N802 - of rclpy
        """The event of clocks that sleep."""
        return _rclpy.ClockEvent if current_call() is None else ClockEvent

    def Clock(self, clock_type: Any) -> Any:  # noqa: N802 - of rclpy
        """Return a new clock."""
        call = current_call()
        return _rclpy.Clock(clock_type) if call is None else ClockHandle(call.program)
