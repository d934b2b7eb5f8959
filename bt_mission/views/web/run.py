"""A mission that this process runs, step by step between the page's requests."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

from bt_mission.sessions.drive import StepDriver
from bt_mission.views.web.server import WebServer

ENDED = "the mission has ended"


class Outcome(Protocol):
    """The report of a mission or of a fleet, as used here."""

    @property
    def verdict(self) -> str:
        """Its verdict."""


R = TypeVar("R", bound=Outcome)


def page_stays(verdict: str) -> str:
    """Return the line for the user after the end of a mission, with its verdict."""
    return f"{ENDED}: {verdict}; the page stays until Ctrl-C"


class ShownRun(Generic[R]):
    """Runs a session for pages. After its end, they stay until the user leaves.

    A server that fails ends nothing: the mission continues without it.

    Args:
        server: Shows the session.
        driver: The running session.
        is_left: Returns whether the user has left. Ending the mission leaves, too.
        say: Called with lines for the user.
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
        """Run the mission, and show it until the user leaves. Return its report."""
        try:
            asyncio.run(self._run())
        except Exception as error:  # noqa: BLE001 - what shows a mission must not break it
            self._say(f"the page failed; the mission continues: {type(error).__name__}: {error}")
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
            self._say(page_stays(self._driver.result.verdict))
