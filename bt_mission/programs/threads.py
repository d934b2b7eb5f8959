"""Threads, locks and thread-local values of programs: one thread runs at a time."""

from __future__ import annotations

import queue
import sys
import threading
from collections import deque
from typing import Any

from typing_extensions import override

from bt_mission.base.stamps import NS
from bt_mission.programs.calls import Call, CallWait, Life, StandIn, current_call

_real_lock = threading.Lock
_real_rlock: Any = vars(threading)["_CRLock"]
_python_rlock: Any = vars(threading)["_PyRLock"]
_real_ident = threading.get_ident
_real_current = threading.current_thread
_real_main = threading.main_thread


class Lock:
    """``threading.Lock``: those who wait for it get it in their order."""

    def __init__(self) -> None:
        self._real = _real_lock()
        self._owner: Call | None = None
        self._waiting: deque[tuple[Call, CallWait]] = deque()

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:  # noqa: FBT001, FBT002 - as it is
        """Take the lock, or wait for it."""
        if not blocking and timeout != -1:
            raise ValueError("can't specify a timeout for a non-blocking call")
        if self._real.acquire(blocking=False):
            self._owner = current_call()
            return True
        call = current_call()
        if not blocking or call is None:
            return blocking and self._real.acquire(timeout=timeout)
        wait = CallWait("waits for a lock", timeout >= 0, lambda: self._owner)
        entry = (call, wait)
        self._waiting.append(entry)
        try:
            return call.program.host.wait(wait, round(timeout * NS) if timeout >= 0 else None)
        finally:
            if entry in self._waiting:
                self._waiting.remove(entry)

    def release(self) -> None:
        """Hand the lock over, or open it."""
        while self._waiting:
            call, wait = self._waiting.popleft()
            if not wait.over.is_over:
                self._owner = call
                wait.over.set_result(True)
                return
        self._owner = None
        self._real.release()

    def locked(self) -> bool:
        """Return whether somebody has it."""
        return self._real.locked()

    def __enter__(self) -> bool:
        return self.acquire()

    def __exit__(self, *_: object) -> None:
        self.release()


def new_lock() -> Any:
    """Replace ``threading.Lock``."""
    return _real_lock() if current_call() is None else Lock()


def new_rlock(*args: Any) -> Any:
    """Replace what makes the locks of ``threading.RLock``."""
    is_real = _real_rlock is not None and current_call() is None
    return _real_rlock(*args) if is_real else _python_rlock(*args)


class SimpleQueue(queue._PySimpleQueue, metaclass=StandIn):  # type: ignore[name-defined,misc]  # private
    """``queue.SimpleQueue``, in Python."""

    _stands_for = queue.SimpleQueue


def get_ident() -> int:
    """Replace ``threading.get_ident``."""
    call = current_call()
    return _real_ident() if call is None else call.life.ident


def current_thread() -> Any:
    """Replace ``threading.current_thread``."""
    call = current_call()
    if call is None:
        return _real_current()
    if call.life is call.program.life:
        return main_thread()
    return _thread_of(call.life, f"ThreadPoolExecutor-0_{call.life.ident}")


def main_thread() -> Any:
    """Replace ``threading.main_thread``."""
    call = current_call()
    return _real_main() if call is None else _thread_of(call.program.life, "MainThread")


def _thread_of(life: Life, name: str) -> Any:
    if life.thread is None:
        life.thread = Thread.of(life, name)
    return life.thread


class Thread(threading.Thread, metaclass=StandIn):
    """``threading.Thread``, on the virtual clock if the code of a program starts it."""

    _stands_for: Any = threading.Thread

    _life: Life | None = None
    _call: Call | None = None
    _is_over = False
    _start: CallWait
    _joining: list[CallWait]

    @classmethod
    def of(cls, life: Life, name: str) -> Thread:
        """Return the object of a thread that the code has not started."""
        thread = cls(name=name, daemon=False)
        thread._life, thread._joining = life, []
        return thread

    @override
    def start(self) -> None:
        call = current_call()
        if call is None:
            super().start()
            return
        if self._life is not None:
            raise RuntimeError("threads can only be started once")
        self._started.set()
        program = call.program
        self._life, self._joining = program.host.new_life(), []
        self._life.thread = self
        getattr(program, "threads", []).append(self)
        self._call = Call(program, self._life, None, None, None, self._run_to_end)
        self._start = CallWait("starts a thread", is_timed=True)
        program.host.start(self._call)
        program.host.wait(self._start)  # as Python does

    def _run_to_end(self) -> None:
        self._start.over.set_result(True)
        try:
            self.run()
        except SystemExit:
            pass
        except Exception as error:  # noqa: BLE001 - whatever its code raises ends the thread alone
            show = getattr(self._call and self._call.program, "show", None)
            if show is not None:
                sys.stderr.write(f"Exception in thread {self.name}:\n")
                show(error)
            else:
                threading.excepthook(threading.ExceptHookArgs((*sys.exc_info(), self)))
        finally:
            self._is_over = True
            for wait in self._joining:
                wait.over.set_result(True)

    @override
    def join(self, timeout: float | None = None) -> None:
        call = current_call()
        if self._life is None:
            super().join(timeout)
            return
        if self._is_over or call is None:
            return
        if call.life is self._life:
            raise RuntimeError("cannot join current thread")
        wait = CallWait("waits for the end of a thread", timeout is not None, lambda: self._call)
        self._joining.append(wait)
        call.program.host.wait(wait, None if timeout is None else round(max(timeout, 0) * NS))

    @override
    def is_alive(self) -> bool:
        return super().is_alive() if self._life is None else not self._is_over

    @property
    @override
    def ident(self) -> int | None:
        return super().ident if self._life is None else self._life.ident


class Timer(Thread):
    """``threading.Timer``."""

    _stands_for = threading.Timer

    def __init__(
        self, interval: float, function: Any, args: Any = None, kwargs: Any = None
    ) -> None:
        super().__init__()
        self.interval, self.function = interval, function
        self.args, self.kwargs = args or [], kwargs or {}
        self.finished = threading.Event()

    def cancel(self) -> None:
        """Do not call the function."""
        self.finished.set()

    @override
    def run(self) -> None:
        if not self.finished.wait(self.interval):
            self.function(*self.args, **self.kwargs)
        self.finished.set()


class Local(metaclass=StandIn):
    """``threading.local``."""

    _stands_for = threading.local

    __slots__ = ("__dict__", "_made", "_parts")

    def __new__(cls, *args: Any, **kwargs: Any) -> Any:
        """Make it, with the values of the thread that makes it."""
        made = object.__new__(cls)
        object.__setattr__(made, "_made", (args, kwargs))
        object.__setattr__(made, "_parts", {get_ident(): {}})
        return made

    def _select(self) -> None:
        """Let the values be those of this thread."""
        parts = object.__getattribute__(self, "_parts")
        ident = get_ident()
        is_new = ident not in parts
        object.__setattr__(self, "__dict__", parts.setdefault(ident, {}))
        if is_new:
            args, kwargs = object.__getattribute__(self, "_made")
            type(self).__init__(self, *args, **kwargs)

    def __getattribute__(self, name: str) -> Any:
        Local._select(self)
        return object.__getattribute__(self, name)

    def __setattr__(self, name: str, value: Any) -> None:
        Local._select(self)
        object.__setattr__(self, name, value)

    def __delattr__(self, name: str) -> None:
        Local._select(self)
        object.__delattr__(self, name)


class LoopLocal(Local):
    """The event loop of each thread, as a policy of ``asyncio`` keeps it."""

    _loop = None
    _set_called = False

    @property
    def all(self) -> list[Any]:
        """Those of all threads."""
        loops = [part.get("_loop") for part in self._parts.values()]
        return [loop for loop in loops if loop is not None]
