"""A sweep on a cluster of which parts are killed, again and again, until it is done."""

from __future__ import annotations

import os
import random
import signal
import socket
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from bt_mission.base.errors import BtMissionError
from bt_mission.commands.sweep.store import ResultStore
from bt_mission.scenarios.concrete.row import ScenarioRow

LONGEST_S = 120.0
LOOK_S = 0.05
MOST_STARTS = 5


class KilledSweep:
    """Runs a sweep to its end while its client, scheduler and workers are killed.

    Args:
        folder: For the results and what the processes say.
        mission: What is swept.
        options: Of ``bt-mission sweep``, besides those of the cluster.
        draws: Decides what is killed, and when.
    """

    def __init__(
        self, folder: Path, mission: Path, options: tuple[str, ...], draws: random.Random
    ) -> None:
        self.results = folder / "results"
        self.killed: list[str] = []
        self._folder = folder
        self._mission = mission
        self._options = options
        self._draws = draws
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        self._address = f"tcp://127.0.0.1:{_free_port()}"

    def run(self, victims: list[str]) -> list[ScenarioRow]:
        """Kill what is named, one after another, each once there are more results; gives all rows.

        Args:
            victims: ``worker``, ``nanny``, ``scheduler`` or ``client``.
        """
        try:
            for victim in victims:
                self._start()
                self._wait_for(self._count() + self._draws.randint(1, 3))
                self._pass(self._draws.uniform(0, 0.3))
                self._kill(victim)
            self._start()
            # A client that has lost its scheduler ends in its own time, and is started again.
            for _ in range(MOST_STARTS):
                self._wait(lambda: not self._is_alive("client"))
                if self._processes["client"].returncode == 0:
                    break
                self._start()
        finally:
            self._end()
        with ResultStore.read(self.results) as store:
            return list(store.rows())

    # ---- processes -----------------------------------------------------------------------

    def _start(self) -> None:
        """Start what does not run: a client that is gone goes on with the sweep."""
        if not self._is_alive("scheduler"):
            port = self._address.rpartition(":")[2]
            self._spawn("scheduler", "dask_scheduler", "--host", "127.0.0.1", "--port", port)
            self._wait(lambda: _answers(int(port)))
        if not self._is_alive("nanny"):
            words = ("--nthreads", "1", "--nworkers", "2", "--host", "127.0.0.1")
            self._spawn("nanny", "dask_worker", self._address, *words)
            self._wait(lambda: len(self._workers()) == 2)
        if not self._is_alive("client"):
            self._spawn_client()

    def _spawn(self, name: str, module: str, *words: str) -> None:
        command = [sys.executable, "-m", f"distributed.cli.{module}", *words, "--no-dashboard"]
        self._processes[name] = self._popen(name, command)

    def _spawn_client(self) -> None:
        command = [sys.executable, "-m", "bt_mission", "sweep", str(self._mission), *self._options]
        command += ["--scheduler", self._address, "-o", str(self.results), "--resume"]
        command += ["--record-worst", "0", "--plain"]
        self._wait(lambda: len(self._workers()) == 2)
        self._processes["client"] = self._popen("client", command)

    def _popen(self, name: str, command: list[str]) -> subprocess.Popen[bytes]:
        with (self._folder / f"{name}.log").open("ab") as log:
            return subprocess.Popen(command, stdout=log, stderr=log, cwd=self._folder)

    def _kill(self, victim: str) -> None:
        self.killed.append(victim)
        if victim == "worker":
            workers = self._workers()
            if workers:
                os.kill(self._draws.choice(workers), signal.SIGKILL)
            return
        self._end_process(victim)
        if victim == "scheduler":  # its workers leave, each in its own time
            self._end_process("nanny")

    def _end_process(self, name: str) -> None:
        process = self._processes.pop(name, None)
        if process is not None:
            children = _children(process.pid)
            process.kill()
            process.wait()
            for child in children:  # they would leave by themselves, in their own time
                _kill_quietly(child)

    def _end(self) -> None:
        for name in ("client", "nanny", "scheduler"):
            self._end_process(name)

    def _is_alive(self, name: str) -> bool:
        process = self._processes.get(name)
        return process is not None and process.poll() is None

    def _workers(self) -> list[int]:
        nanny = self._processes.get("nanny")
        pids = [] if nanny is None else _children(nanny.pid)
        return [pid for pid in pids if "spawn_main" in _command(pid)]

    def _count(self) -> int:
        try:
            with ResultStore.read(self.results) as store:
                return len(store.ids())
        except BtMissionError:
            return 0

    def _wait_for(self, count: int) -> None:
        self._wait(lambda: self._count() >= count or not self._is_alive("client"))

    def _pass(self, seconds: float) -> None:
        """Let the processes go on for a while."""
        with suppress(subprocess.TimeoutExpired):
            self._processes["scheduler"].wait(seconds)

    def _wait(self, done: Callable[[], bool]) -> None:
        for _ in range(round(LONGEST_S / LOOK_S)):
            if done():
                return
            self._pass(LOOK_S)
        logs = "\n".join(path.read_text()[-2000:] for path in self._folder.glob("*.log"))
        raise AssertionError(f"not within {LONGEST_S:g} s\n{logs}")


def _children(pid: int) -> list[int]:
    """Those that any thread of a process has started."""
    pids: list[int] = []
    for path in Path(f"/proc/{pid}/task").glob("*/children"):
        with suppress(OSError):
            pids += map(int, path.read_text().split())
    return pids


def _command(pid: int) -> str:
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes().decode(errors="replace")
    except OSError:
        return ""


def _kill_quietly(pid: int) -> None:
    with suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


def _free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        port: int = listener.getsockname()[1]
        return port


def _answers(port: int) -> bool:
    with socket.socket() as client:
        return client.connect_ex(("127.0.0.1", port)) == 0
