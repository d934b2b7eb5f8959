"""Code of users that holds the clock: found, named, and interrupted on request.

Everything runs on one thread, which stands still while a callback of somebody else's code sleeps,
loops or waits: a node under ``nodes:``, a Python leaf, an action of a test. That thread cannot see
itself stand still, nor can virtual time. So this module is the one exception to two rules: it
starts a thread, and measures wall time. The thread only looks. It runs while a session has code of
users, and its looks take less than 1 % of the time.

A look reads the stack of the watched thread and its state in the kernel. A stack says whose code
runs, so that calls of callbacks cost nothing. A state says whether the thread waits or computes:
processor time per callback would cost 2 us, and cannot tell a thread that waits from one that gets
no processor on a busy machine.
"""

from __future__ import annotations

import ctypes
import gc
import os
import select
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import accumulate, chain, pairwise, repeat, starmap
from operator import methodcaller
from pathlib import Path
from queue import SimpleQueue
from types import FrameType, TracebackType
from typing import Any, Self, TypeVar

from bt_mission.base.code_owner import owner_of
from bt_mission.base.errors import BtMissionError, described
from bt_mission.base.interrupts import SAME_WISH_S, SIGNALS, TookTooLong, takes_signal
from bt_mission.base.wall_clock import Stopwatch

LOOK_S = 0.01
"""Wall time between two looks, s."""

HELD_S = 2.0
"""A callback that lasts this long holds the clock, s of wall time."""

WAITED_S = 0.05
"""Code that waits this long in a row holds the clock, too, s of wall time: a tick of the mission.
Shorter waits change no tick, and a lock of the middleware may cause them.
"""

URGE_S = 0.5
"""After a signal, a callback is interrupted once it has lasted this long, s, and again after it."""

LEAVE_S = 1.5
"""After a signal, or a limit, the process ends if a callback still does not return, s."""

LAST_WORDS_S = 1.0
"""The time for saving files before the process ends, s."""

UNATTENDED_S = 10.0
"""The limit of a callback where nobody can press Ctrl-C: in tests and sweeps, s."""

_KICK = signal.SIGRTMIN + 7
"""The signal that interrupts the main thread in a callback."""

T = TypeVar("T")


class Interrupted(BaseException):
    """Raised in a callback that holds the clock, after a signal or at its limit."""


class HeldClockError(BtMissionError):
    """Code of a user has held the clock."""

    code = "BT-918"


class LeftError(BtMissionError):
    """Code of a user has tried to end the process."""

    code = "BT-913"


@dataclass(frozen=True)
class Holder:
    """A callback that holds the clock.

    Attributes:
        callback: Class and function, such as ``Server.execute``.
        place: Where it is, such as ``server.py:12``.
    """

    callback: str
    place: str

    def __str__(self) -> str:
        return f"{self.callback} ({self.place})"


# ---- whose code a stack shows -----------------------------------------------------------------


def callback_in(innermost: FrameType | None) -> Holder | None:
    """Return the callback of a user that a stack shows, and where it is; None without one.

    It is the outermost code of users that we have called, or that a module for callbacks has. A
    stack within a debugger shows none: a person holds the clock.
    """
    return _callback_of(_stack_from([innermost]))


def _stack_from(innermost: Iterable[FrameType | None]) -> list[Any]:
    """Return the frames from the only one of an iterable outwards; the last is None."""
    stack: list[Any] = []
    outwards: Any = getattr
    with suppress(AttributeError):  # of None, after the outermost
        stack.extend(accumulate(chain(innermost, repeat("f_back")), outwards))
    return stack


def _stack_of(thread: int) -> list[Any]:
    """Return the frames of another thread, which does not run meanwhile.

    CPython 3.11 has crashed where it did. So all is one call of compiled code, which gives the
    interpreter to no other thread unless it collects garbage, and with that finalizers run.
    """
    innermost = map(methodcaller("get", thread), starmap(sys._current_frames, [()]))  # noqa: SLF001
    collects = gc.isenabled()
    gc.disable()
    try:
        return _stack_from(innermost)
    finally:
        if collects:
            gc.enable()


def _callback_of(stack: Sequence[Any]) -> Holder | None:
    inner: list[FrameType] = []
    callback: list[FrameType] = []
    for frame, outer in pairwise(stack):
        owner = owner_of(frame.f_code.co_filename)
        if owner == "debugger":
            return None
        if owner in ("user", "package"):
            inner.append(frame)
            caller = owner_of(outer.f_code.co_filename) if outer else ""
            if caller == "caller" or (owner == "user" and caller == "ours"):
                callback = list(inner)
    if not callback:
        return None
    written = [
        frame for frame in callback if owner_of(frame.f_code.co_filename) == "user"
    ] or callback[-1:]
    code = written[-1].f_code
    name = getattr(code, "co_qualname", code.co_name).replace("<locals>.", "")
    return Holder(name, f"{Path(written[0].f_code.co_filename).name}:{written[0].f_lineno}")


# ---- ways out of a user's code ----------------------------------------------------------------


def refuse_leaving(error: BaseException) -> None:
    """Raise LeftError for an error that would end the process; return for any other.

    Code of users may not end a run: not by ``sys.exit``, ``KeyboardInterrupt``, ``GeneratorExit``,
    nor by a class that is no ``Exception``. A KeyboardInterrupt that a signal has raised
    is not theirs.

    Raises:
        LeftError: With what the code raised, and where.
    """
    if isinstance(error, Exception | Interrupted | TookTooLong):
        return
    if isinstance(error, KeyboardInterrupt):
        is_theirs = bool(_hearing) and not _hearing[0].signals
    else:
        file = getattr(sys.modules.get(type(error).__module__), "__file__", None)
        is_theirs = isinstance(error, SystemExit | GeneratorExit) or (
            file is not None and owner_of(file) in ("library", "user")
        )
    if is_theirs:
        what = described(error)
        raise LeftError(f"code of a mission must not end the process: {what}") from error


class _Contained:
    """Turns what would end the process into an error, around calls of a user's code."""

    def __enter__(self) -> None:
        return None

    def __exit__(
        self,
        _kind: type[BaseException] | None,
        error: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        if error is not None:
            refuse_leaving(error)


CONTAINED = _Contained()
"""``with CONTAINED: call()``."""


# ---- the watch --------------------------------------------------------------------------------

_hearing: list[ClockWatch] = []
"""The watch that hears signals, at most one: a process has one file for them."""

_given_up: dict[int, Callable[[Holder], None]] = {}
"""Called instead of ending the process, by the thread whose code does not return."""


class ClockWatch:
    """Looks at the thread that has made it, until it is closed.

    Args:
        progress: Returns the number of callbacks so far: two looks with one number see one call.
        is_virtual: Whether time stands still while a callback runs.
        limit_s: Wall time after which a callback is interrupted, s; None for no limit.
    """

    def __init__(
        self,
        progress: Callable[[], int],
        *,
        is_virtual: bool,
        limit_s: float | None = None,
    ) -> None:
        self.last_words: list[Callable[[], object]] = []
        """Called before the process ends because a callback does not return."""
        self.is_held = False
        """Whether a callback has lasted for a while, and has not returned yet."""
        self._progress, self._is_virtual, self._limit_s = progress, is_virtual, limit_s
        self._thread = threading.get_ident()
        self._is_main = is_main_thread()
        self._state = os.open(f"/proc/self/task/{threading.get_native_id()}/stat", os.O_RDONLY)
        self._clock = time.pthread_getcpuclockid(self._thread)
        self._holders: dict[str, Holder] = {}
        self._lines: set[tuple[str, str]] = set()
        self._overrun: Holder | None = None
        self._last_progress: int | None = None
        self._call: tuple[int, str] | None = None
        self._since = self._since_look = Stopwatch()
        self._since_urge: Stopwatch | None = None
        self._waited_s = self._held_s = 0.0
        self._own_s, self._all_s = time.clock_gettime(self._clock), time.process_time()
        self.signals: list[int] = []
        """The signals so far, by number."""
        self._since_signal: Stopwatch | None = None
        self._wishes = 0
        self._reader, self._writer = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
        self._hear()
        self._is_over = self._is_closed = False
        self._watcher = threading.Thread(target=self._watch, name="clock watch", daemon=True)
        self._watcher.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Look no more."""
        if self._is_closed:
            return
        self._is_over = self._is_closed = True
        os.write(self._writer, b"\0")
        self._watcher.join()
        if self in _hearing:
            _hearing.remove(self)
            signal.set_wakeup_fd(-1)
        for file in (self._reader, self._writer, self._state):
            os.close(file)

    def take_overrun(self) -> HeldClockError | None:
        """Return once the error of a callback that was interrupted at its limit."""
        overrun, self._overrun = self._overrun, None
        if overrun is None:
            return None
        return HeldClockError(f"{overrun} did not return within {self._limit_s:g} s of wall time")

    @property
    def flaws(self) -> Sequence[str]:
        """A line for each callback that has held the virtual clock: the times are then wrong."""
        if not self._is_virtual:
            return ()
        return tuple(
            f"the times are wrong: {holder} held the clock [{HeldClockError.code}]"
            for holder in self._holders.values()
        )

    # ---- inside --------------------------------------------------------------------------

    def _hear(self) -> None:
        if not self._is_main:
            return
        signal.signal(_KICK, _interrupt)
        if not _hearing:
            before = signal.set_wakeup_fd(self._writer, warn_on_full_buffer=False)
            if before == -1:
                _hearing.append(self)
            else:  # an event loop hears them
                signal.set_wakeup_fd(before)

    def _watch(self) -> None:
        poll = select.poll()
        poll.register(self._reader, select.POLLIN)
        while not self._is_over:
            if poll.poll(LOOK_S * 1e3):
                self._take_signals(os.read(self._reader, 64))
            try:
                self._look()
            except OSError:  # its clock and state: the thread has ended
                self._is_over = True

    def _take_signals(self, numbers: bytes) -> None:
        for number in numbers:
            last = self._since_signal
            if number not in SIGNALS:
                continue
            is_same = (
                last is not None and self.signals[-1] == number and last.elapsed_s < SAME_WISH_S
            )
            self.signals.append(number)
            if not is_same:
                self._since_signal = Stopwatch()
                self._wishes += 1

    def _look(self) -> None:
        progress, before = self._progress(), self._last_progress
        self._last_progress = progress
        holder = None
        if progress == before:
            with suppress(AttributeError):  # it has changed all the same: no frame, the next look
                holder = _callback_of(_stack_of(self._thread))
        elapsed_s, self._since_look = self._since_look.elapsed_s, Stopwatch()
        own_s, self._own_s = _passed(self._own_s, time.clock_gettime(self._clock))
        all_s, self._all_s = _passed(self._all_s, time.process_time())
        if holder is None:
            self._call, self.is_held = None, False
            return
        call = (progress, holder.callback)
        if call != self._call:
            self._call, self._since, self._held_s = call, Stopwatch(), 0.0
            elapsed_s = LOOK_S
        state = os.pread(self._state, 512, 0).rpartition(b")")[2].split()[0]
        waits = state == b"S" and all_s < 0.8 * elapsed_s
        self._held_s += elapsed_s if waits else own_s
        self._waited_s = self._waited_s + elapsed_s if waits else 0.0
        self._judge(holder)
        self._limit(holder)

    def _judge(self, holder: Holder) -> None:
        """Name a callback that holds the clock, once in each way."""
        does_wait = self._is_virtual and self._waited_s >= WAITED_S
        if does_wait or self._held_s >= HELD_S:
            self._holders.setdefault(holder.callback, holder)
        if self._since.elapsed_s >= HELD_S:
            held = "holds the clock; virtual time stands still while it runs"
            blocked = "blocks the mission; nothing else happens while it runs"
            self._tell(holder, held if self._is_virtual else blocked)
        elif does_wait:
            self._tell(holder, "waits for the wall clock; virtual time stands still meanwhile")

    def _tell(self, holder: Holder, what: str) -> None:
        if (holder.callback, what) not in self._lines:
            self._lines.add((holder.callback, what))
            _say[-1](f"{holder} {what}")

    def _limit(self, holder: Holder) -> None:
        """Interrupt a callback after a signal, or at its limit; leave if it does not return."""
        age_s = self._since.elapsed_s
        self.is_held = age_s >= URGE_S
        if self._limit_s is not None and age_s >= self._limit_s:
            self._overrun = holder
            self._urge(holder, is_last=age_s - self._limit_s >= LEAVE_S)
        elif self._since_signal is not None and self.is_held:
            is_last = self._wishes > 1 or self._since_signal.elapsed_s >= LEAVE_S
            self._urge(holder, is_last=is_last)

    def _urge(self, holder: Holder, *, is_last: bool) -> None:
        if is_last:
            self._leave(holder)
        elif self._since_urge is None or self._since_urge.elapsed_s >= URGE_S:
            self._since_urge = Stopwatch()
            if self._is_main:
                signal.pthread_kill(self._thread, _KICK)
            else:  # it is not woken, but leaves a loop
                _raise_in(self._thread, ctypes.py_object(Interrupted))

    def _leave(self, holder: Holder) -> None:
        """End the process without the thread that does not return, or give that thread up."""
        self._is_over = True
        if (give_up := _given_up.get(self._thread)) is not None:
            _take_back(self._thread)
            give_up(holder)
            return
        _say[-1](f"{holder} does not return: leaving without it")
        speaker = threading.Thread(target=self._speak_last, daemon=True)
        speaker.start()
        speaker.join(LAST_WORDS_S)
        os._exit(128 + self.signals[-1] if self.signals else 1)

    def _speak_last(self) -> None:
        for call in self.last_words:
            try:
                call()
            except BaseException as error:  # noqa: BLE001 - the others are called as well
                _say[-1](described(error))


def _raise_in(thread: int, kind: ctypes.py_object[type[BaseException]] | None) -> None:
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), kind)


def _take_back(thread: int) -> None:
    """Take an exception back that a thread has not raised, since it is blocked.

    While one waits to be raised, CPython 3.11 does not get past the first instruction of a
    function that is traced, in any thread. Only a thread that raises its own ends that.
    """
    _raise_in(thread, None)
    with suppress(Interrupted):
        _raise_in(threading.get_ident(), ctypes.py_object(Interrupted))
        while True:
            pass


def _passed(before_s: float, now_s: float) -> tuple[float, float]:
    """Return the time since an earlier reading, and the new reading."""
    return now_s - before_s, now_s


def _interrupt(_number: int, frame: FrameType | None) -> None:
    if callback_in(frame) is not None and not takes_signal(frame):
        raise Interrupted


def _to_stderr(line: str) -> None:
    with suppress(OSError, ValueError):  # nobody reads it, or it is closed: the watch goes on
        sys.stderr.write(f"{line}\n")
        sys.stderr.flush()


_say: list[Callable[[str], None]] = [_to_stderr]


@contextmanager
def told_by(say: Callable[[str], None]) -> Iterator[None]:
    """Pass lines about the clock to a function, which another thread calls."""
    _say.append(say)
    try:
        yield
    finally:
        _say.remove(say)


def is_main_thread() -> bool:
    """Return whether this is the thread that gets the signals of the process."""
    return threading.current_thread() is threading.main_thread()


def run_apart(call: Callable[[], T]) -> T:
    """Call a function in a separate thread, which is given up when its code does not return.

    Raises:
        HeldClockError: It was given up.
    """
    results: SimpleQueue[tuple[T | None, BaseException | None]] = SimpleQueue()

    def give_up(holder: Holder) -> None:
        results.put((None, HeldClockError(f"{holder} does not return")))

    def run() -> None:
        _given_up[threading.get_ident()] = give_up
        try:
            results.put((call(), None))
        except BaseException as error:  # noqa: BLE001 - raised by the caller's thread
            results.put((None, error))
        finally:
            del _given_up[threading.get_ident()]

    threading.Thread(target=run, daemon=True).start()
    result, error = results.get()
    if error is not None:
        raise error
    return result  # type: ignore[return-value]  # of the call
