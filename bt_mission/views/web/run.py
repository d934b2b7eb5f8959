"""A mission that this process carries out, step by step between the page's requests."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

from bt_mission.sessions.drive import StepDriver
from bt_mission.views.web.server import WebServer

ENDED = "the mission has ended"


class Outcome(Protocol):
    """The report of a mission or of a fleet, as far as it matters here."""

    @property
    def status(self) -> str:
        """What it came to."""


R = TypeVar("R", bound=Outcome)


def page_stays(status: str) -> str:
    """Return what people are told when a mission has ended, with what it came to."""
    return f"{ENDED}: {status}; the page stays until Ctrl-C"


class ShownRun(Generic[R]):
    """Drives a session while pages look on. When it has ended, they stay until somebody leaves.

    A server that fails ends nothing: the mission goes on without it.

    Args:
        server: Shows the session.
        driver: The session on its way.
        is_left: Has somebody left? Who ends the mission leaves with it.
        say: Told what people have to know, a line at a time.
    """

    def __init__(
        self,
        server: WebServer,
        driver: StepDriver[R],
        is_left: Callable[[], bool],
        say: Callable[[str], None],
    ) -> None:
        self._server = server
        self._driver = driver
        self._is_left = is_left
        self._say = say

    def run_to_the_end(self) -> R:
        """Carry the mission out, and show it until somebody leaves; gives its report."""
        try:
            asyncio.run(self._run())
        except Exception as error:  # noqa: BLE001 - what shows a mission must not break it
            self._say(f"the page failed, the mission goes on: {type(error).__name__}: {error}")
        # Raises what the session has raised.
        return self._driver.finish()

    async def _run(self) -> None:
        asyncio.get_running_loop().call_soon(self._advance)
        await self._server.serve(lambda: self._driver.fault is not None or self._is_left())

    def _advance(self) -> None:
        wait_s = self._driver.advance()
        if not self._driver.is_over:
            asyncio.get_running_loop().call_later(wait_s, self._advance)
        elif self._driver.result is not None and not self._is_left():
            self._say(page_stays(self._driver.result.status))
