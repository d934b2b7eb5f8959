"""The server of the page: ASGI, on the event loop of the process, without a thread."""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import resources

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from typing_extensions import override

from bt_mission.base.wall_clock import Stopwatch
from bt_mission.views.html.pages import render
from bt_mission.views.web.gate import HEADERS, Gate
from bt_mission.views.web.guarded_server import (
    Connections,
    FrameRate,
    GuardedServer,
    listening_socket,
)
from bt_mission.views.web.live import LiveMission
from bt_mission.views.web.page_requests import LONGEST
from bt_mission.views.web.pages import OpenPages

FRAME_S = 0.03
"""Wall time between two looks at what is new."""

FAST_FRAME_S = 0.5
"""The same beside a mission that runs as fast as possible: each look takes time from it."""

IDLE_S = 0.5
"""The same as long as no page is open."""

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
        gate = Gate(
            Starlette(routes=[*files, *routes]),
            self.token,
            options.host,
            connections.admitted,
            self.headers,
        )
        self._server = GuardedServer(gate, connections, FRAMES, most_bytes=4 * LONGEST)

    async def serve(self, until: Callable[[], bool]) -> None:
        """Serve, and look for changes many times a second, until a condition is true.

        Raises:
            Exception: An exception of the mission's view.
        """
        loop = asyncio.get_running_loop()
        faults: list[Exception] = []

        def frame() -> None:
            try:
                if until():
                    self._server.should_exit = True
                    return
                loop.call_later(self._frame_s, frame)
                self._look()
            except Exception as error:  # noqa: BLE001 - raised again where it can be seen
                faults.append(error)
                self._server.should_exit = True

        loop.call_soon(frame)
        await self._server.serve([self._socket])
        if faults:
            raise faults[0]

    def close(self) -> None:
        """Listen no longer."""
        self._socket.close()

    def _look(self) -> None:
        """Look for changes, for pages; there are none if a page has all its data."""

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
        self._since_look: Stopwatch | None = None
        index = render("views/web/page/index.html")
        super().__init__(index, options, WebSocketRoute("/live", self.pages.open))

    @override
    def _look(self) -> None:
        since = self._since_look
        if since is not None and not self.pages.are_open and since.elapsed_s < IDLE_S:
            return
        self._since_look = Stopwatch()
        self._shown.look(self.pages.panels)
        self.pages.wake()


@cache
def page_files() -> dict[str, bytes]:
    """Return the files that a page refers to, by name."""
    folder = resources.files("bt_mission.views.web") / "page"
    return {
        file.name: file.read_bytes()
        for file in folder.iterdir()
        if file.name.rpartition(".")[2] in TYPES
    }
