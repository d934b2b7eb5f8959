"""Signals, ``breakpoint()`` and the end of the process in programs."""

from __future__ import annotations

import os
import pdb  # noqa: T100 - `breakpoint()` of programs
import signal
import sys
from collections.abc import Callable
from functools import partial
from typing import Any

import rclpy
from rclpy.signals import SignalHandlerOptions

from bt_mission.programs.calls import Call, Program, current_call

_real_exit = os._exit
_real_signal, _real_getsignal = signal.signal, signal.getsignal
_real_set_wakeup_fd = signal.set_wakeup_fd
_real_breakpoint = sys.breakpointhook
_real_install: Any = rclpy.install_signal_handlers
_real_uninstall: Any = rclpy.uninstall_signal_handlers


def _set_handler(number: int, handler: Any) -> Any:
    call = current_call()
    if call is None:
        return _real_signal(number, handler)
    program = call.program
    if call.life is not program.life:
        raise ValueError("signal only works in main thread of the main interpreter")
    former = handler_of(program, number)
    program.handlers[number] = handler
    if number == signal.SIGINT:
        program.ends_with_signal = False  # the handler replaces that of rclpy
    return former


def handler_of(program: Program, number: int) -> Any:
    """Return the handler of a signal in a program, as ``signal.getsignal`` does."""
    default = signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL
    return program.handlers.get(number, default)


def _get_handler(number: int) -> Any:
    call = current_call()
    return _real_getsignal(number) if call is None else handler_of(call.program, number)


def _set_wakeup_fd(file: int, *, warn_on_full_buffer: bool = True) -> int:
    call = current_call()
    if call is None:
        return _real_set_wakeup_fd(file, warn_on_full_buffer=warn_on_full_buffer)
    former, call.program.wakeup_file = call.program.wakeup_file, file
    return former


def _install(options: SignalHandlerOptions = SignalHandlerOptions.ALL) -> None:
    call = current_call()
    if call is None:
        _real_install(options)
        return
    call.program.ends_with_signal = options in (
        SignalHandlerOptions.ALL,
        SignalHandlerOptions.SIGINT,
    )


def _uninstall() -> None:
    call = current_call()
    if call is None:
        _real_uninstall()
        return
    call.program.ends_with_signal = False


def _break(*args: Any, **kwargs: Any) -> Any:
    """Stop in the debugger, on the terminal: nothing else runs meanwhile, and no time passes."""
    if current_call() is None or os.environ.get("PYTHONBREAKPOINT"):
        return _real_breakpoint(*args, **kwargs)
    debugger = pdb.Pdb(nosigint=True, stdin=sys.stdin, stdout=sys.__stdout__)
    debugger.set_trace(sys._getframe(1))
    return None


def _leave(status: int) -> Any:
    call = current_call()
    if call is None:
        _real_exit(status)
    call.program.host.leave(call, status)


def _refused(real: Callable[..., Any], what: str) -> Callable[..., Any]:
    """Return a function that refuses what would be of the whole process, in programs."""

    def refuse(*args: Any) -> Any:
        if current_call() is None:
            return real(*args)
        raise OSError(
            f"a program on the virtual clock cannot {what}: start a thread, or another program "
            "with subprocess [BT-215]"
        )

    return refuse


_COPY = "fork, since its copy would have no clock"
_REPLACE = "replace its process, in which others run"


def action_of(program: Program, call: Call, number: int) -> Callable[[], Any] | None:
    """Return what a signal has the main thread of a program do; None for nothing."""
    handler: Any = handler_of(program, number)
    if handler == signal.SIG_IGN:
        return None
    if handler == signal.SIG_DFL or handler is None:
        return partial(sys.exit, 128 + number)

    def handle() -> Any:
        if program.wakeup_file >= 0:  # a loop of asyncio reads the number
            os.write(program.wakeup_file, bytes([number]))
        return handler(number, call.gr_frame)

    return handle


REPLACED: tuple[tuple[Any, dict[str, Any]], ...] = (
    (
        signal,
        {"signal": _set_handler, "getsignal": _get_handler, "set_wakeup_fd": _set_wakeup_fd},
    ),
    (sys, {"breakpointhook": _break}),
    (
        os,
        {
            "_exit": _leave,
            "fork": _refused(os.fork, _COPY),
            "forkpty": _refused(os.forkpty, _COPY),
            "execv": _refused(os.execv, _REPLACE),
            "execve": _refused(os.execve, _REPLACE),
        },
    ),
)
"""Functions of modules, and what a program finds in their place."""

OF_RCLPY = {"install_signal_handlers": _install, "uninstall_signal_handlers": _uninstall}
"""The same of rclpy."""
