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

_real_exit, _real_fork = os._exit, os.fork
_real_signal, _real_getsignal = signal.signal, signal.getsignal
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


def _fork() -> int:
    if current_call() is None:
        return _real_fork()
    raise OSError(
        "a program on the virtual clock cannot fork, since its copy would have no clock: start a "
        "thread, or another program with subprocess [BT-215]"
    )


def action_of(program: Program, call: Call, number: int) -> Callable[[], Any] | None:
    """Return what a signal has the main thread of a program do; None for nothing."""
    handler: Any = handler_of(program, number)
    if handler == signal.SIG_IGN:
        return None
    if handler == signal.SIG_DFL or handler is None:
        return partial(sys.exit, 128 + number)
    return lambda: handler(number, call.gr_frame)


REPLACED: tuple[tuple[Any, dict[str, Any]], ...] = (
    (signal, {"signal": _set_handler, "getsignal": _get_handler}),
    (sys, {"breakpointhook": _break}),
    (os, {"_exit": _leave, "fork": _fork}),
)
"""Functions of modules, and what a program finds in their place."""

OF_RCLPY = {"install_signal_handlers": _install, "uninstall_signal_handlers": _uninstall}
"""The same of rclpy."""
