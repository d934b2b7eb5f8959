"""Sim, servers and executive as separate processes, for the few tests that need them."""

from __future__ import annotations

import fcntl
import os
import signal
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from bt_mission.base.python_process import python_command, python_environment
from bt_mission.scenarios.faults.errors import ScenarioError

LOCAL = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
"""Environment in which processes of this machine find each other."""

LOOK_S = 0.05
"""How often the output of a process is looked at while something is waited for."""


def command(*arguments: str) -> list[str]:
    """The command line of ``bt-mission`` in this environment."""
    return python_command("-u", "-m", "bt_mission", *arguments)


class Process:
    """A process whose output goes to a file, so that it never waits for a reader.

    Args:
        name: For people.
        file: Takes what it says, on standard output and standard error.
    """

    def __init__(
        self, name: str, arguments: list[str], environment: dict[str, str], file: Path
    ) -> None:
        self.name = name
        self._file = file
        self._looked = 0
        self._stream: IO[bytes] = file.open("wb")
        self._process = subprocess.Popen(
            arguments,
            env=python_environment(os.environ | environment),
            stdin=subprocess.DEVNULL,
            stdout=self._stream,
            stderr=subprocess.STDOUT,
        )

    @property
    def output(self) -> str:
        """Its output so far."""
        return self._file.read_text(encoding="utf-8", errors="replace")

    @property
    def pid(self) -> int:
        """Its process id."""
        return self._process.pid

    @property
    def code(self) -> int | None:
        """Its exit code; None while it runs."""
        return self._process.poll()

    def until(self, words: str, *, within: float = 60.0) -> str:
        """Wait until it says something that it has not been waited for before; gives its output.

        Args:
            within: Seconds, on the wall.

        Raises:
            ScenarioError: When it does not, with its output.
        """
        for _ in range(max(round(within / LOOK_S), 1)):
            ended = self._ended_within(LOOK_S)
            output = self.output
            at = output.find(words, self._looked)
            if at >= 0:
                self._looked = at + len(words)
                return output
            if ended:
                raise self._failed(f"ended with {self.code}, without printing '{words}'")
        raise self._failed(f"has not said '{words}' within {within:g} s")

    def wait(self, *, within: float = 60.0) -> int:
        """Wait for its end; gives its exit code.

        Args:
            within: Seconds, on the wall.

        Raises:
            ScenarioError: When it does not end, with its output.
        """
        if not self._ended_within(within):
            raise self._failed(f"has not ended within {within:g} s")
        return self._process.returncode

    def interrupt(self) -> None:
        """Send SIGINT, as Ctrl-C does."""
        self._process.send_signal(signal.SIGINT)

    def kill(self) -> None:
        """End it at once, as a crash would; nothing happens where it has ended."""
        if self.code is None:
            self._process.kill()
        self._process.wait()
        self._stream.close()

    def _ended_within(self, seconds: float) -> bool:
        try:
            self._process.wait(seconds)
        except subprocess.TimeoutExpired:
            return False
        return True

    def _failed(self, what: str) -> ScenarioError:
        return ScenarioError(f"the process '{self.name}' {what}:\n{self.output}")


DOMAINS = range(1, 102)
"""DDS domain ids. Those above reach into Linux' range of ephemeral ports."""

READY = "ready: scan and odometry have come"


class LiveGraph:
    """A ROS graph on this machine with its own domain.

    Its processes are killed at the end of the test, and their output is shown if the test fails.
    Times are those of the wall: use the fixture ``stage`` where it will do.

    Args:
        folder: For output and missions.
        domain_id: Of DDS.
    """

    def __init__(self, folder: Path, domain_id: int) -> None:
        self.folder = folder
        self.domain_id = domain_id
        self.environment = {"ROS_DOMAIN_ID": str(domain_id), **LOCAL}
        self.processes: list[Process] = []

    def start(self, *arguments: str) -> Process:
        """Start ``bt-mission`` with these arguments, such as ``"topics", "list"``."""
        return self.start_program(arguments[0], *command(*arguments))

    def start_program(self, name: str, *arguments: str) -> Process:
        """Start any program in this graph.

        Args:
            name: For people; a number is put behind it where it is taken.
        """
        same = sum(process.name.split(" ")[0] == name for process in self.processes)
        full = f"{name} {same + 1}" if same else name
        file = self.folder / f"{full.replace(' ', '_')}.log"
        self.processes.append(Process(full, list(arguments), self.environment, file))
        return self.processes[-1]

    def robot(
        self, world: str | Path = "empty_arena", robot: str = "waffle", *sim: str
    ) -> tuple[Process, Process]:
        """Start a robot in a world, and its action servers; gives both when they are ready.

        Args:
            world: A world's name or file.
            robot: A robot's name or file.
            sim: More options of ``bt-mission sim``, such as ``"--speed", "5"``.
        """
        simulator = self.start("sim", "--world", str(world), "--robot", str(robot), *sim)
        servers = self.start("servers", "--robot", str(robot))
        servers.until(READY)
        return simulator, servers

    def run(self, mission: str | Path, *options: str) -> Process:
        """Start a mission on the robots that are there.

        Args:
            mission: A file, the name of a shipped mission, or a mission as text (of several lines).
            options: More options of ``bt-mission run --attach``.
        """
        text = str(mission)
        if "\n" in text:
            number = sum(1 for _ in self.folder.glob("mission_*.yaml")) + 1
            path = self.folder / f"mission_{number}.yaml"
            path.write_text(text, encoding="utf-8")
            text = str(path)
        return self.start("run", text, "--attach", "--plain", *options)

    def close(self) -> None:
        """Kill what still runs."""
        for process in reversed(self.processes):
            process.kill()


@contextmanager
def own_domain(folder: Path | None = None) -> Iterator[int]:
    """A DDS domain id that no other test on this machine has, as long as this is open.

    It is claimed by a lock on a file, which the system takes back however a process ends. A domain
    in which a process listens is skipped.

    Args:
        folder: Where the locks are; None is that for temporary files.

    Raises:
        ScenarioError: When all are taken.
    """
    parent = folder or Path(tempfile.gettempdir())
    first = os.getpid() % len(DOMAINS)
    for domain_id in (*DOMAINS[first:], *DOMAINS[:first]):
        try:
            lock = (parent / f"bt_mission_domain_{domain_id}.lock").open("a")
        except OSError:  # another user's
            continue
        with lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                continue
            if is_in_use(domain_id):
                continue
            yield domain_id
            return
    raise ScenarioError(f"all {len(DOMAINS)} DDS domains are taken by other tests of this machine")


def is_in_use(domain_id: int) -> bool:
    """Return whether a process has the unicast port of a DDS domain's first participant.

    The port is that of the DDSI-RTPS specification, section 9.6.1.1: 7400 + 250 domain + 10.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("", 7400 + 250 * domain_id + 10))
        except OSError:
            return True
    return False
