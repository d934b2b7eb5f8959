"""A server of pages within a test, and a client that speaks to it as a browser does."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable, Iterator
from contextlib import closing, suppress
from typing import Any, TypeVar
from urllib.parse import urlsplit

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from bt_mission.views.web.live import LiveMission
from bt_mission.views.web.server import PageServer, WebOptions, WebServer

ANY_PORT = WebOptions(port=0)
Server = TypeVar("Server", bound=PageServer)


def serve(
    shown: LiveMission,
    scene: Callable[[WebServer], Awaitable[None]],
    options: WebOptions = ANY_PORT,
) -> None:
    """Serve a mission while a scene is played."""
    play_with(WebServer(shown, options), scene)


def play_with(
    server: Server, scene: Callable[[Server], Awaitable[None]], limit_s: float = 60
) -> None:
    """Play a scene while a server serves."""

    async def play() -> None:
        with closing(server):
            is_over = False
            serving = asyncio.create_task(server.serve(lambda: is_over))
            try:
                await asyncio.wait_for(scene(server), limit_s)
            finally:
                is_over = True
                await serving

    asyncio.run(play())


def live(server: WebServer, **options: Any) -> connect:
    """Open the WebSocket of a page."""
    address = urlsplit(server.link)
    options = {"origin": f"http://{address.netloc}", "max_size": None} | options
    return connect(f"ws://{address.netloc}{address.path}live", **options)


async def closed(connection: Any) -> tuple[int, str]:
    """The code and the reason with which the server closes a connection."""
    with suppress(ConnectionClosed):
        async for _ in connection:
            pass
    assert connection.close_code is not None
    return connection.close_code, connection.close_reason


class PageModel:
    """What a page knows by what it was told."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self.parts: dict[str, Any] = {}
        self.nodes: dict[int, list[Any]] = {}
        self.log: list[list[Any]] = []
        self.variables: dict[str, str] = {}
        self.goals: dict[str, list[Any]] = {}
        self.messages = 0

    async def until(self, condition: Callable[[PageModel], Any]) -> None:
        """Take what comes until a condition holds."""
        while not condition(self):
            self.take(json.loads(await self.socket.recv()))

    async def ask(self, do: str, **fields: Any) -> None:
        """Send a request."""
        await self.socket.send(json.dumps({"do": do, **fields}))

    async def settle(self) -> None:
        """Wait until all that was asked for has been taken."""
        self.parts.pop("series", None)
        await self.ask("series", name="")
        await self.until(lambda it: "series" in it.parts)

    def take(self, changes: dict[str, Any]) -> None:
        """Take a message in, as the page does."""
        self.messages += 1
        if "tree" in changes:
            self.nodes.clear()
        if "tree" in changes or "values_are_new" in changes:
            self.goals.clear()
            self.variables.clear()
        if "log_is_new" in changes:
            self.log.clear()
        self.nodes |= {row[0]: row for row in changes.pop("nodes", ())}
        self.goals |= {row[0]: row for row in changes.pop("goals", ())}
        self.variables |= dict(changes.pop("variables", ()))
        self.log += changes.pop("log", ())
        self.parts |= changes


async def fetch(
    server: PageServer, path: str, *, form: str | None = None, **headers: str
) -> tuple[int, dict[str, str], str]:
    """Ask for a path, with headers of one's own; gives status, headers and body.

    Args:
        form: Is sent by POST.
    """
    address = urlsplit(server.link)
    lines = {"Host": address.netloc, "Connection": "close"} | headers
    if form is not None:
        lines["Content-Length"] = str(len(form))
    reader, writer = await asyncio.open_connection("127.0.0.1", address.port)
    asked = "".join(f"{name}: {value}\r\n" for name, value in lines.items())
    method = "GET" if form is None else "POST"
    writer.write(f"{method} {path} HTTP/1.1\r\n{asked}\r\n{form or ''}".encode())
    head, _, body = (await reader.read()).decode().partition("\r\n\r\n")
    writer.close()
    first, *rest = head.split("\r\n")
    return int(first.split()[1]), dict(_split(rest)), body


def _split(lines: list[str]) -> Iterator[tuple[str, str]]:
    for line in lines:
        name, _, value = line.partition(": ")
        yield name.lower(), value
