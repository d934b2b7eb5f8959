"""``bt-mission`` as processes of their own, which end with the test."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import IO

from bt_mission.testing.errors import ScenarioError

LOCAL = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
"""Environment in which processes of this machine find each other."""

LOOK_S = 0.05
"""How often the output of a process is looked at while something is waited for."""


def command(*arguments: str) -> list[str]:
    """The command line of ``bt-mission`` in this environment."""
    return [sys.executable, "-u", "-m", "bt_mission", *arguments]


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
            env=os.environ | environment,
            stdin=subprocess.DEVNULL,
            stdout=self._stream,
            stderr=subprocess.STDOUT,
        )

    @property
    def output(self) -> str:
        """What it has said so far."""
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
            said = self.output
            at = said.find(words, self._looked)
            if at >= 0:
                self._looked = at + len(words)
                return said
            if ended:
                raise self._failed(f"ended with {self.code}, and has not said '{words}'")
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
        """What Ctrl-C does."""
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
