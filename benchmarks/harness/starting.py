"""How the process of a script is started: by Python, or as a fork of one that has the libraries."""

from __future__ import annotations

import asyncio
import json
import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Protocol

PRELOADED = "__import__('benchmarks.harness.preloaded').harness.preloaded.main()"
"""Leaves no name in the main module, which is to be the script's."""
ROOT = Path(__file__).resolve().parent.parent.parent


@dataclass(frozen=True)
class Start:
    """What is started.

    Args:
        command: A script and its arguments.
        folder: It runs in.
        environment: All its variables.
        output: A file that takes what it says; None is the terminal.
    """

    command: list[str]
    folder: Path
    environment: Mapping[str, str]
    output: Path | None


class Started(Protocol):
    """A process in a group of its own."""

    pid: int

    async def wait(self) -> int:
        """Wait for its end; gives its exit code, below zero that of a signal."""


class Starter:
    """Starts each script with a new Python."""

    async def start(self, what: Start) -> Started:
        """Start a script."""
        with (what.output or Path("/dev/null")).open("wb") as file:
            return await asyncio.create_subprocess_exec(
                sys.executable,
                *what.command,
                cwd=what.folder,
                env=what.environment,
                stdin=asyncio.subprocess.DEVNULL,
                stdout=file if what.output else None,
                stderr=file if what.output else None,
                start_new_session=True,
            )

    async def close(self) -> None:
        """Nothing is left."""


class Fork:
    """A script in a fork."""

    def __init__(self, pid: int, ended: asyncio.Future[int]) -> None:
        self.pid = pid
        self._ended = ended

    async def wait(self) -> int:
        """Wait for its end; gives its exit code."""
        return await asyncio.shield(self._ended)


class ForkStarter:
    """Starts scripts as forks of a process that has imported the libraries.

    Args:
        environment: The variables with which that process imports it.
    """

    def __init__(self, environment: Mapping[str, str]) -> None:
        self._environment = environment
        self._numbers = count()
        self._begun: dict[int, asyncio.Future[int]] = {}
        self._ended: dict[int, asyncio.Future[int]] = {}
        self._process: asyncio.subprocess.Process | None = None
        self._reading: asyncio.Task[None] | None = None
        self._opening = asyncio.Lock()

    async def start(self, what: Start) -> Started:
        """Start a script; its output goes to a file."""
        assert what.output is not None
        async with self._opening:
            if self._process is None:
                await self._open()
        assert self._process is not None
        assert self._process.stdin is not None
        loop, number = asyncio.get_running_loop(), next(self._numbers)
        begun = self._begun[number] = loop.create_future()
        ended = self._ended[number] = loop.create_future()
        request = {
            "number": number,
            "command": what.command,
            "folder": str(what.folder),
            "environment": dict(what.environment),
            "output": str(what.output),
        }
        async with self._opening:  # one request at a time
            self._process.stdin.write(json.dumps(request).encode() + b"\n")
            pid = await begun
        return Fork(pid, ended)

    async def close(self) -> None:
        """End the process that has the libraries; its forks have ended."""
        if self._process is not None:
            with suppress(ProcessLookupError):
                self._process.kill()
            await self._process.wait()
        if self._reading is not None:
            await self._reading

    async def _open(self) -> None:
        self._process = await asyncio.create_subprocess_exec(
            sys.executable,
            "-c",
            PRELOADED,
            cwd=ROOT,
            env=self._environment,
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            start_new_session=True,
        )
        self._reading = asyncio.ensure_future(self._read(self._process))

    async def _read(self, process: asyncio.subprocess.Process) -> None:
        """Take answers until it has ended; whoever still waits then has failed."""
        assert process.stdout is not None
        async for line in process.stdout:
            record = json.loads(line)
            if "pid" in record:
                self._begun[record["number"]].set_result(record["pid"])
            else:
                self._ended[record["number"]].set_result(record["code"])
        for future in (*self._begun.values(), *self._ended.values()):
            if not future.done():
                future.set_result(1)
