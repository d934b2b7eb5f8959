"""Part of the test session: `--processes N` collects once, and runs the tests in N forks.

A fork has what the collection has imported. It takes file by file from the process that collected,
those with most tests of processes first: these wait, while others compute. Two forks share a file
when no other is left, so what a module's fixture makes is mostly made once. Each fork has its own
DDS domain and folder for temporary files. Where one dies, its test fails, and another takes over.
"""

from __future__ import annotations

import faulthandler
import gc
import os
import signal
import tempfile
import traceback
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from itertools import groupby
from multiprocessing.connection import Connection, Pipe, wait
from pathlib import Path
from typing import Any, BinaryIO

import pytest
from _pytest.faulthandler import fault_handler_stderr_fd_key

from bt_mission.testing.live_graph import own_domain


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add `--processes`."""
    parser.addoption("--processes", type=int, default=0, help="forks that run the tests")


def pytest_configure(config: pytest.Config) -> None:
    """Collect without looking for cycles: what is collected stays."""
    if config.getoption("processes"):
        gc.disable()


def pytest_runtestloop(session: pytest.Session) -> bool | None:
    """Run the tests in forks, if that is asked for."""
    config = session.config
    if not config.getoption("processes") or config.option.collectonly or session.testsfailed:
        return None
    if reporter := config.pluginmanager.getplugin("terminalreporter"):
        reporter.showfspath = False  # several files at a time
    config._tmp_path_factory.getbasetemp()  # type: ignore[attr-defined]  # empties a given one
    gc.freeze()
    gc.enable()
    forks = Forks(session)
    try:
        forks.run(config.getoption("processes"))
    finally:
        forks.close()
    if session.shouldfail:
        raise session.Failed(session.shouldfail)
    if session.shouldstop:
        raise session.Interrupted(session.shouldstop)
    return True


def by_file(items: Sequence[pytest.Item]) -> list[deque[int]]:
    """Return the numbers of the items of each file, those with most tests of processes first."""
    files = [deque(group) for _, group in groupby(range(len(items)), lambda n: items[n].path)]

    def processes(numbers: deque[int]) -> int:
        return sum(items[number].get_closest_marker("process") is not None for number in numbers)

    return sorted(files, key=processes, reverse=True)


class Fork:
    """A process, and the numbers of the items that it has: the one that runs, and the next."""

    def __init__(self, session: pytest.Session, name: str) -> None:
        self.connection, there = Pipe()
        self.items: deque[int] = deque()
        self.file: deque[int] = deque()
        """What is left of the file that it is at."""
        self.error = ""
        """The traceback with which it ends."""
        self._outputs: list[BinaryIO] = []
        self.pid = os.fork()
        if not self.pid:
            self.connection.close()
            _work(session, there, name)
        there.close()

    def hold(self, outputs: tuple[int, ...]) -> None:
        """Keep the files with its output and the stacks of its threads: they outlive it."""
        with suppress(OSError):  # it has died
            files = Path(f"/proc/{self.pid}/fd")
            self._outputs = [(files / str(number)).open("rb") for number in outputs]

    def last_words(self) -> str:
        """Return its traceback, what the last test has printed, and the stacks at a hang."""
        texts = [self.error]
        for output in self._outputs:
            with output:
                texts.append(output.read().decode(errors="replace").strip())
        return "\n".join(filter(None, texts))

    def give(self, item: int | None) -> None:
        """Send the number of an item, or None after the last."""
        if item is not None:
            self.items.append(item)
        with suppress(ConnectionError):  # it has died, as the end of its reports will say
            self.connection.send(item)


def received(connection: Connection) -> tuple[Any] | None:
    """Return what a fork has sent; None where it has ended."""
    try:
        return (connection.recv(),)
    except (EOFError, ConnectionError):
        return None


class Forks:
    """Forks, and the items that wait for one."""

    def __init__(self, session: pytest.Session) -> None:
        self._session = session
        self._files = deque(by_file(session.items))
        self._forks: dict[Any, Fork] = {}
        self._started = 0

    def run(self, count: int) -> None:
        """Run all items, or as many as until the session is to stop."""
        for _ in range(min(count, len(self._session.items))):
            self._start()
        while self._forks:
            for connection in wait(list(self._forks)):
                fork = self._forks[connection]
                if message := received(fork.connection):
                    self._take(fork, *message)
                else:  # not while the error is handled: the next fork would see it
                    self._end(fork)

    def close(self) -> None:
        """End the forks that are left when a session is interrupted."""
        for fork in self._forks.values():
            os.kill(fork.pid, signal.SIGTERM)
            os.waitpid(fork.pid, 0)

    def _next(self, fork: Fork) -> int | None:
        if self._session.shouldfail or self._session.shouldstop:
            return None
        while not fork.file and self._files:
            fork.file = self._files.popleft()
        if not fork.file:
            fork.file = max((other.file for other in self._forks.values()), key=len)
        return fork.file.popleft() if fork.file else None

    def _start(self) -> None:
        fork = Fork(self._session, f"process{self._started}")
        self._started += 1
        self._forks[fork.connection] = fork
        for _ in range(2):  # the next one tells which fixtures stay
            fork.give(self._next(fork))

    def _take(self, fork: Fork, message: Any) -> None:
        hook = self._session.config.hook
        if isinstance(message, tuple):
            fork.hold(message)
            return
        if message is None:
            fork.items.popleft()
            if fork.items:
                fork.give(self._next(fork))
            return
        if isinstance(message, str):
            fork.error = message
            return
        report = hook.pytest_report_from_serializable(config=self._session.config, data=message)
        hook.pytest_runtest_logreport(report=report)

    def _end(self, fork: Fork) -> None:
        del self._forks[fork.connection]
        fork.connection.close()
        _, status = os.waitpid(fork.pid, 0)
        last_words = fork.last_words()
        if not fork.items:
            return
        item = self._session.items[fork.items.popleft()]
        code = os.waitstatus_to_exitcode(status)
        text = f"its process ended with {code}\n{last_words}".rstrip()
        report = pytest.TestReport(item.nodeid, item.location, {}, "failed", text, "call")
        self._session.config.hook.pytest_runtest_logreport(report=report)
        fork.file.extendleft(fork.items)
        self._files.appendleft(fork.file)
        if any(self._files) and not self._session.shouldfail:
            self._start()


class Reports:
    """Sends the reports of a fork."""

    def __init__(self, config: pytest.Config, connection: Connection) -> None:
        self._config, self._connection = config, connection

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Send one."""
        self._connection.send(
            self._config.hook.pytest_report_to_serializable(config=self._config, report=report)
        )


def _work(session: pytest.Session, connection: Connection, name: str) -> None:
    """Run items until there is none left; the process ends."""
    code = 1
    try:
        with _of_its_own(session.config, name) as outputs:
            connection.send(outputs)
            session.config.pluginmanager.register(Reports(session.config, connection))
            number = connection.recv()
            while number is not None:
                following = connection.recv()
                item = session.items[number]
                item.ihook.pytest_runtest_protocol(
                    item=item, nextitem=None if following is None else session.items[following]
                )
                connection.send(None)
                number = following
        code = 0
    except BaseException:  # noqa: BLE001 - the process ends, whatever it was
        with suppress(OSError):  # the process that collected has ended
            connection.send(traceback.format_exc())
    finally:
        os._exit(code)


@contextmanager
def _of_its_own(config: Any, name: str) -> Iterator[tuple[int, ...]]:
    """Give a fork what it must not share. Yield the files that tell how it has ended."""
    plugins = config.pluginmanager
    plugins.unregister(plugins.getplugin("terminalreporter"))
    capture = plugins.getplugin("capturemanager")
    capture.stop_global_capturing()
    capture.start_global_capturing()
    captured = capture._global_capturing
    files = [output.tmpfile for output in (captured.out, captured.err) if output is not None]
    stacks = tempfile.TemporaryFile(buffering=0)  # noqa: SIM115 - of a crash or a hang, as it ends
    faulthandler.enable(stacks)
    config.stash[fault_handler_stderr_fd_key] = stacks.fileno()
    folder = config._tmp_path_factory.getbasetemp() / name
    folder.mkdir(mode=0o700)
    config._tmp_path_factory._basetemp = folder
    with ExitStack() as stack:
        os.environ["ROS_DOMAIN_ID"] = str(stack.enter_context(own_domain()))
        printed = tuple(file.fileno() for file in files) if capture._method == "fd" else ()
        yield (*printed, stacks.fileno())
