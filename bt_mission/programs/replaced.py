"""The functions that block or read a clock, replaced while there are programs.

:func:`install` puts them into their modules, once, and a function returns them. Each looks for the
call that runs: outside of the code of programs it does as the original, also in other threads.
"""

from __future__ import annotations

import atexit
import concurrent.futures  # noqa: F401 - so that it is complete
import datetime
import queue
import random
import selectors
import sys
import threading
import time
import uuid
from collections.abc import Callable
from functools import partial
from types import ModuleType
from typing import Any

import rclpy
import rclpy.clock
import rclpy.context
import rclpy.executors
import rclpy.impl.rcutils_logger
import rclpy.logging
import rclpy.node
import rclpy.wait_for_message
from rclpy import utilities
from rclpy.callback_groups import ReentrantCallbackGroup

from bt_mission.base import user_loops
from bt_mission.base.code_owner import owner_of
from bt_mission.base.stamps import NS
from bt_mission.programs import clocks, goals, logs, signals, threads
from bt_mission.programs.calls import Call, CallWait, current_call, running_loop
from bt_mission.programs.executors import MultiThreadedExecutor, SingleThreadedExecutor
from bt_mission.programs.mains import LoopFinder, MainProgram, ProgramContext, RclpyOfNodes

_real_lock = threading.Lock()
_users = 0
_kept: list[dict[str, Any]] = []
_FINDER: Any = LoopFinder()
_real_datetime = datetime.datetime

_real_global_executor = rclpy.get_global_executor
_real_spin = rclpy.spin
_real_wait_for_message = rclpy.wait_for_message.wait_for_message
_real_uuid4 = uuid.uuid4
_real_at_exit = atexit.register


def _global_executor() -> Any:
    call = current_call()
    return _real_global_executor() if call is None else call.program.serving()


def _spin(node: Any, executor: Any = None) -> None:
    if current_call() is None:
        _real_spin(node, executor)
        return
    executor = _global_executor() if executor is None else executor
    try:
        executor.add_node(node)
        executor.spin()
    finally:
        executor.remove_node(node)


def _wait_for_message(
    msg_type: Any, node: Any, topic: str, *, qos_profile: Any = 1, time_to_wait: Any = -1
) -> Any:
    call = current_call()
    if call is None:
        return _real_wait_for_message(
            msg_type, node, topic, qos_profile=qos_profile, time_to_wait=time_to_wait
        )
    got: list[Any] = []
    wait = CallWait("waits for a message", is_timed=time_to_wait >= 0)

    def take(message: Any) -> None:
        got.append(message)
        wait.over.set_result(True)

    # It is taken in any case, also while all threads of the executor are busy.
    subscription = node.create_subscription(
        msg_type, topic, take, qos_profile, callback_group=ReentrantCallbackGroup()
    )
    host = call.program.host
    host.serve_always(node, subscription)
    try:
        host.wait(wait, round(time_to_wait * NS) if time_to_wait >= 0 else None)
    finally:
        host.serve_as_others(subscription)
        node.destroy_subscription(subscription)
    return (True, got[0]) if got else (False, None)


def _at_exit(function: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
    call = current_call()
    if call is None or not isinstance(call.program, MainProgram):
        return _real_at_exit(function, *args, **kwargs)
    call.program.at_exit.append(partial(function, *args, **kwargs))
    return function


def _uuid4() -> uuid.UUID:
    call = current_call()
    if call is None:
        return _real_uuid4()
    return uuid.UUID(int=call.program.random.getrandbits(128), version=4)


def _drawn(name: str, real: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
    call = current_call()
    return (real if call is None else getattr(call.program.random, name))(*args, **kwargs)


_DRAWS = (
    *("betavariate", "choice", "choices", "expovariate", "gammavariate", "gauss", "getrandbits"),
    *("getstate", "lognormvariate", "normalvariate", "paretovariate", "randbytes", "randint"),
    *("random", "randrange", "sample", "seed", "setstate", "shuffle", "triangular", "uniform"),
    *("vonmisesvariate", "weibullvariate"),
)

REPLACED: tuple[tuple[Any, dict[str, Any]], ...] = (
    (time, {"sleep": clocks.sleep, **clocks.READERS, **clocks.CALENDAR}),
    (
        threading,
        {
            "Lock": threads.new_lock,
            "_allocate_lock": threads.new_lock,
            "_CRLock": threads.new_rlock,
            "_time": clocks.READERS["monotonic"],
            "Thread": threads.Thread,
            "Timer": threads.Timer,
            "local": threads.Local,
            "get_ident": threads.get_ident,
            "current_thread": threads.current_thread,
            "main_thread": threads.main_thread,
        },
    ),
    (queue, {"SimpleQueue": threads.SimpleQueue, "time": clocks.READERS["monotonic"]}),
    (selectors, {"DefaultSelector": clocks.ProgramSelector}),
    (user_loops, {"take_round": clocks.take_round}),
    (random, {name: partial(_drawn, name, getattr(random, name)) for name in _DRAWS}),
    (uuid, {"uuid4": _uuid4}),
    (
        rclpy,
        {
            "spin": _spin,
            "get_global_executor": _global_executor,
            "Context": ProgramContext,
            **signals.OF_RCLPY,
        },
    ),
    (rclpy.context, {"Context": ProgramContext}),
    (utilities, {"Context": ProgramContext}),
    (rclpy.node, {"_rclpy": RclpyOfNodes()}),
    (
        rclpy.impl.rcutils_logger,
        {"_rclpy": logs.RclpyOfLogs(), "supported_filters": logs.FILTERS},
    ),
    (rclpy.logging, {"_rclpy": logs.RclpyOfLogs()}),
    (atexit, {"register": _at_exit}),
    (
        rclpy.executors,
        {
            "SingleThreadedExecutor": SingleThreadedExecutor,
            "MultiThreadedExecutor": MultiThreadedExecutor,
        },
    ),
    (rclpy.clock, {"_rclpy": clocks.RclpyOfClocks()}),
    (rclpy.wait_for_message, {"wait_for_message": _wait_for_message}),
    *signals.REPLACED,
    goals.REPLACED,
)
"""Modules, and what a program finds in them."""


def install() -> Callable[[], None]:
    """Put the functions into their modules. Return a function that ends that, once."""
    global _users  # noqa: PLW0603 - modules are one for all threads
    with _real_lock:
        _users += 1
        if _users == 1:
            for module, new in REPLACED:
                _kept.append({name: vars(module)[name] for name in new})
                vars(module).update(new)
            sys.meta_path.insert(0, _FINDER)
    left = [None]

    def end() -> None:
        global _users  # noqa: PLW0603
        with _real_lock:
            if not left:
                return
            left.clear()
            _users -= 1
            if _users == 0:
                for (module, _), kept in zip(REPLACED, _kept, strict=True):
                    vars(module).update(kept)
                _kept.clear()
                sys.meta_path.remove(_FINDER)

    return end


def enter(call: Call) -> tuple[Any, Any, Any]:
    """Give the code of a call its default context, ``datetime``, and loop of ``asyncio`` that runs.

    Return the former ones. A class that is pickled has to be found in its module: ``datetime`` of
    others stays.
    """
    former = utilities.g_default_context, datetime.datetime, running_loop(call.loop)
    utilities.g_default_context = call.program.context  # type: ignore[assignment]
    datetime.datetime = clocks.Datetime  # type: ignore[misc]
    return former


def leave(call: Call, former: tuple[Any, Any, Any]) -> None:
    """End :func:`enter`."""
    call.program.context = utilities.g_default_context
    utilities.g_default_context, datetime.datetime, loop = former  # type: ignore[misc]
    call.loop = running_loop(loop)


_NEW = {
    id(vars(module)[name]): new
    for module, names in REPLACED
    for name, new in names.items()
    if name != "_rclpy"
} | {id(_real_datetime): clocks.Datetime}
"""The replacements of functions and classes, by the identity of the original."""


def adopt(factory: Any) -> None:
    """Let a module of a user that was imported before, and those it imports, use the replacements.

    ``from time import sleep`` has taken the original. A replacement does as the original, unless
    the code of a program calls it.
    """
    waiting = [sys.modules.get(getattr(factory, "__module__", ""))]
    seen: set[int] = set()
    while waiting:
        module = waiting.pop()
        file = getattr(module, "__file__", None)
        if module is None or id(module) in seen or not file or owner_of(file) != "user":
            continue
        seen.add(id(module))
        names = vars(module)
        for name, value in tuple(names.items()):
            if id(value) in _NEW:
                names[name] = _NEW[id(value)]
            elif isinstance(value, ModuleType):
                waiting.append(value)
            else:
                waiting.append(sys.modules.get(getattr(value, "__module__", None) or ""))
