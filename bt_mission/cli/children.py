"""Commands in other processes: this program again."""

from __future__ import annotations

import asyncio
import ctypes
import json
import os
import re
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from bt_mission.base.python_process import python_command, python_environment

_LINK = re.compile(r"in a browser: (http://[\w.:\[\]]+/[\w-]+/)")
"""A whole line, since others may show what a mission says."""
MOST_LINES = 200
MOST_OUTPUT = 2**26
"""Bytes of its output that are kept."""
PATIENCE_S = 3.0
"""How long a process may take to end by a signal, before it gets the next one."""
_END_WITH_PARENT = 1
"""PR_SET_PDEATHSIG of prctl: the signal that a process gets when its parent has ended."""


class Spare:
    """A process that gets ready for a run, and waits for the words of its command."""

    def __init__(self) -> None:
        self._started = asyncio.create_task(started("bt_mission.cli.preloaded"))

    async def take(self, words: Sequence[str]) -> asyncio.subprocess.Process:
        """Have it run a command; another process runs it if this one has ended. Raises OSError."""
        with suppress(OSError):
            process = await self._started
            if process.returncode is None:
                assert process.stdin is not None
                process.stdin.write(json.dumps(words).encode() + b"\n")
                await process.stdin.drain()
                return process
        return await started("bt_mission", *words)

    async def drop(self) -> None:
        """End it."""
        with suppress(OSError):
            process = await self._started
            with suppress(ProcessLookupError):
                process.kill()
            await process.communicate()


async def started(
    module: str, *words: str, longest_line: int = 2**16, is_quiet: bool = False
) -> asyncio.subprocess.Process:
    """Start a module of this program, which ends with this process.

    Args:
        longest_line: Bytes of a line that can be read from it.
        is_quiet: Discard its standard error.

    Raises:
        OSError: The machine cannot start it, or the command is too long for it.
        ValueError: A word has a null character.
    """
    return await asyncio.create_subprocess_exec(
        *python_command("-m", module, *words),
        env=python_environment(),
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.DEVNULL if is_quiet else asyncio.subprocess.PIPE,
        limit=longest_line,
        start_new_session=True,
        preexec_fn=_end_with_parent if sys.platform == "linux" else None,
    )


class ChildCommand:
    """A command in another process, until it ends or is stopped.

    Args:
        trial: The file that it reads, deleted when it has ended; None for no such file.
        words: The command and its options.
        spare: Runs it, instead of a new process.
    """

    def __init__(
        self, trial: Path | None, words: Sequence[str], spare: Spare | None = None
    ) -> None:
        self.lines: list[str] = []
        """Its lines on standard error, and how it ended if it was killed or did not start."""
        self.link = ""
        """The link of its page, once it is served."""
        self.output = ""
        self.code: int | None = None
        self._trial, self._words, self._spare = trial, words, spare
        self._process: asyncio.subprocess.Process | None = None
        self._task = asyncio.create_task(self._run())

    async def wait(self) -> None:
        """Wait for the end of its process."""
        await asyncio.wait([self._task])

    @property
    def is_over(self) -> bool:
        """Whether its process has ended."""
        return self._task.done()

    async def stop(self) -> None:
        """End it: by Ctrl-C, which lets the robot stop, then by force.

        The force reaches what it has started, too, which may hold its output open.
        """
        for number in (signal.SIGINT, signal.SIGINT, signal.SIGKILL):
            if self.is_over:
                break
            if self._process is not None:
                with suppress(ProcessLookupError):
                    if number == signal.SIGKILL:
                        os.killpg(self._process.pid, number)
                    elif self._process.returncode is None:
                        self._process.send_signal(number)
            await asyncio.wait([self._task], timeout=PATIENCE_S)

    async def _run(self) -> None:
        try:
            await self._run_process()
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            self.lines.append(f"cannot start the command: {reason}")
        finally:
            if self._trial is not None:
                self._trial.unlink(missing_ok=True)

    async def _run_process(self) -> None:
        if self._spare is None:
            process = await started("bt_mission", *self._words)
        else:
            process = await self._spare.take(self._words)
        self._process = process
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.close()
        try:
            output, _ = await asyncio.gather(_start_of(process.stdout), self._listen(process))
            self.output = output.decode("utf-8", "replace")
            self.code = await process.wait()
        finally:
            if process.returncode is None:
                process.kill()
        if self.code < 0:
            name = signal.strsignal(-self.code) or "unknown"
            self.lines.append(f"the process was ended by signal {-self.code} ({name})")

    async def _listen(self, process: asyncio.subprocess.Process) -> None:
        assert process.stderr is not None
        while line := await _line_of(process.stderr):
            text = line.decode("utf-8", "replace").rstrip()
            if self._trial is not None:
                text = text.replace(str(self._trial), "mission")
            if not self.link and (link := _LINK.fullmatch(text)):
                self.link = link[1]
            elif len(self.lines) < MOST_LINES:
                self.lines.append(text)

    @property
    def result(self) -> Any:
        """Its output, read as JSON; None if it is not JSON."""
        try:
            return json.loads(self.output)
        except ValueError:
            return None


async def _start_of(stream: asyncio.StreamReader) -> bytes:
    """Read a stream to its end, and return as much of it as is kept."""
    kept = bytearray()
    while part := await stream.read(2**16):
        kept += part[: MOST_OUTPUT - len(kept)]
    return bytes(kept)


async def _line_of(stream: asyncio.StreamReader) -> bytes:
    """Return the next line of a stream, without those that are too long; empty at its end."""
    while True:
        with suppress(ValueError):
            return await stream.readline()


def _end_with_parent() -> None:
    """Have Linux end this process with its parent, even if that is killed."""
    ctypes.CDLL(None).prctl(_END_WITH_PARENT, signal.SIGKILL)
