"""The processes of a run and of a proof: this program again, with the text of the editor."""

from __future__ import annotations

import asyncio
import ctypes
import json
import re
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from starlette.websockets import WebSocket, WebSocketDisconnect
from websockets.asyncio.client import connect
from websockets.exceptions import WebSocketException

_LINK = re.compile(r"in a browser: (http://\S+)")
MOST_LINES = 200
TRY_LATER = 1013
_END_WITH_PARENT = 1
"""PR_SET_PDEATHSIG of prctl: the signal that a process gets when its parent has ended."""


class Child:
    """A command in another process, until it ends or is stopped.

    Args:
        trial: The file that it reads, deleted when it has ended.
        words: The command and its options.
    """

    def __init__(self, trial: Path, words: Sequence[str]) -> None:
        self.lines: list[str] = []
        """Its lines on standard error."""
        self.link = ""
        """The link of its page, once it is served."""
        self.output = ""
        self.code: int | None = None
        self._trial, self._words = trial, words
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
        """End it: by Ctrl-C, which lets the robot stop, then by force."""
        for number in (signal.SIGINT, signal.SIGINT, signal.SIGKILL):
            if self.is_over:
                break
            if self._process is not None and self._process.returncode is None:
                with suppress(ProcessLookupError):
                    self._process.send_signal(number)
            await asyncio.wait([self._task], timeout=3.0)

    async def _run(self) -> None:
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "bt_mission", *self._words),
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
            start_new_session=True,
            preexec_fn=_end_with_parent if sys.platform == "linux" else None,
        )
        self._process = process
        assert process.stdout is not None
        try:
            output, _ = await asyncio.gather(process.stdout.read(), self._listen(process))
            self.output = output.decode("utf-8", "replace")
            self.code = await process.wait()
        finally:
            if process.returncode is None:
                process.kill()
            self._trial.unlink(missing_ok=True)

    async def _listen(self, process: asyncio.subprocess.Process) -> None:
        assert process.stderr is not None
        async for line in process.stderr:
            text = line.decode("utf-8", "replace").rstrip().replace(str(self._trial), "mission")
            link = _LINK.search(text)
            if link:
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


def _end_with_parent() -> None:
    """Have Linux end this process with its parent, even if that is killed."""
    ctypes.CDLL(None).prctl(_END_WITH_PARENT, signal.SIGKILL)


async def relay(page: WebSocket, link: str) -> None:
    """Connect a page with the WebSocket of a child, until one of them leaves."""
    await page.accept()
    address = urlsplit(link)
    try:
        async with connect(
            f"ws://{address.netloc}{address.path}live",
            origin=f"http://{address.netloc}",
            max_size=None,
            compression=None,
        ) as child:
            tasks = [
                asyncio.create_task(_to_child(page, child)),
                asyncio.create_task(_to_page(page, child)),
            ]
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
    except (OSError, WebSocketException):
        pass
    with suppress(RuntimeError, WebSocketDisconnect):
        await page.close(TRY_LATER)


async def _to_child(page: WebSocket, child: Any) -> None:
    while True:
        await child.send(await page.receive_text())


async def _to_page(page: WebSocket, child: Any) -> None:
    async for message in child:
        if isinstance(message, bytes):
            await page.send_bytes(message)
        else:
            await page.send_text(message)
