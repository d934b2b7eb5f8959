"""The server of the page: ASGI, on the event loop of the process, without a thread."""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from typing_extensions import override

from bt_mission.base.wall_clock import Stopwatch
from bt_mission.views.html.pages import render
from bt_mission.views.web.gate import HEADERS, TokenGate
from bt_mission.views.web.guarded_server import (
    Connections,
    FrameRate,
    GuardedServer,
    listening_socket,
)
from bt_mission.views.web.live import LiveMission
from bt_mission.views.web.page_requests import LONGEST
from bt_mission.views.web.pages import OpenPages

if TYPE_CHECKING:
    from bt_mission.sessions.drive import StepDriver

FRAME_S = 0.03
"""Wall time between two looks at what is new."""

FAST_FRAME_S = 0.25
"""The same beside a mission that runs as fast as possible: each look takes time from it."""

IDLE_S = 0.5
"""The same as long as no page is open."""

PASSES = 8
"""Passes of the event loop between two turns of a mission that does not wait: the number from a
page's request to the response.
"""

FRAMES = FrameRate(long_run_s=20.0, most=60)
"""The rate of messages of a page."""

TYPES = {
    "html": "text/html; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "svg": "image/svg+xml",
}


@dataclass(frozen=True)
class WebOptions:
    """The address of the page, and its rights.

    Attributes:
        port: 0 takes any that is free.
        is_read_only: Whether pages may only watch.
        frame_s: Wall time between two looks for changes while a page is open.
    """

    host: str = "127.0.0.1"
    port: int = 8080
    is_read_only: bool = False
    frame_s: float = FRAME_S


class PageServer:
    """Serves a page with its files, from :meth:`serve` on.

    Args:
        index: The page.
        options: Where, and to whom.
        routes: Served besides, below the same link.

    Raises:
        BtMissionError: Where it cannot listen there.
    """

    headers = HEADERS
    """Those of every answer."""

    def __init__(self, index: str, options: WebOptions, *routes: BaseRoute) -> None:
        self._files = {**page_files(), "index.html": index.encode()}
        self._frame_s = options.frame_s
        self._socket = listening_socket(options.host, options.port)
        self.token = secrets.token_urlsafe(16)
        self.port: int = self._socket.getsockname()[1]
        host = f"[{options.host}]" if ":" in options.host else options.host
        self.link = f"http://{host}:{self.port}/{self.token}/"
        files = (Route("/", self._file), Route("/{name}", self._file))
        connections = Connections()
        gate = TokenGate(
            Starlette(routes=[*files, *routes]),
            self.token,
            options.host,
            connections.admitted,
            self.headers,
        )
        self._server = GuardedServer(gate, connections, FRAMES, most_bytes=4 * LONGEST)

    async def serve(self, until: Callable[[], bool]) -> None:
        """Serve until a condition is true; it is tested many times a second."""
        async with self._serving() as serving:
            while not (until() or serving.done()):
                await asyncio.wait((serving,), timeout=self._frame_s)

    def close(self) -> None:
        """Listen no longer."""
        self._socket.close()

    @asynccontextmanager
    async def _serving(self) -> AsyncIterator[asyncio.Task[None]]:
        """Serve while it is entered; the task is done where the server has failed."""
        serving = asyncio.create_task(self._server.serve([self._socket]))
        try:
            yield serving
        finally:
            self._server.should_exit = True
            await serving

    async def _file(self, request: Request) -> Response:
        """Return a file of the page: a request's name is looked up, never opened."""
        name = request.path_params.get("name", "index.html")
        content = self._files.get(name)
        if content is None:
            return Response("There is no such file.\n", 404, media_type="text/plain")
        return Response(content, headers={"content-type": TYPES[name.rpartition(".")[2]]})


class WebServer(PageServer):
    """Serves a mission to pages.

    Args:
        shown: The mission of the pages.
        options: See :class:`PageServer`.
    """

    def __init__(self, shown: LiveMission, options: WebOptions) -> None:
        self._shown = shown
        self.pages = OpenPages(shown, is_read_only=options.is_read_only)
        index = render("views/web/page/index.html")
        super().__init__(index, options, WebSocketRoute("/live", self.pages.open))

    @override
    async def serve(self, until: Callable[[], bool], driver: StepDriver[Any] | None = None) -> None:
        """Serve until a condition is true, and look for changes many times a second.

        Args:
            until: The condition.
            driver: Takes the steps of a session of this process in between.

        Raises:
            Exception: An exception of the mission's view.
        """
        shown, pages = self._shown, self.pages
        since: Stopwatch | None = None
        sent: object = None
        async with self._serving() as serving:
            if driver is not None:
                self._advance(driver)
            while not (until() or serving.done()):
                if since is None or pages.are_open or since.elapsed_s >= IDLE_S:
                    since = Stopwatch()
                    shown.look(pages.panels)
                if sent != (sent := (shown.board.revision, shown.picture)):
                    for page in pages.all:
                        page.changed.set()
                await asyncio.wait((serving,), timeout=self._frame_s)

    def _advance(self, driver: StepDriver[Any], passes: int = 0) -> None:
        """Take the steps that are due, again and again, with passes of the event loop between."""
        loop = asyncio.get_running_loop()
        if passes:
            loop.call_soon(self._advance, driver, passes - 1)
        elif not driver.is_over:
            wait_s = driver.advance()
            if wait_s > 0:
                loop.call_later(wait_s, self._advance, driver)
            else:
                loop.call_soon(self._advance, driver, PASSES)


@cache
def page_files() -> dict[str, bytes]:
    """Return the files that a page refers to, by name."""
    folder = resources.files("bt_mission.views.web") / "page"
    return {
        file.name: file.read_bytes()
        for file in folder.iterdir()
        if file.name.rpartition(".")[2] in TYPES
    }
