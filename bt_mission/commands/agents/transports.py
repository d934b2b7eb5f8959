"""How clients reach the server of agents: standard input and output, or HTTP on this machine."""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import Callable, Coroutine, MutableMapping
from contextlib import closing, suppress
from typing import Any

from mcp.server.mcpserver import MCPServer
from mcp.server.transport_security import TransportSecuritySettings

from bt_mission.commands.agents.server import LONGEST_CALL
from bt_mission.views.web.gate import App, Receive, Scope, Send, TokenGate
from bt_mission.views.web.guarded_server import (
    Connections,
    FrameRate,
    GuardedServer,
    listening_socket,
)

LOOPBACK = "127.0.0.1"
PATH = "/mcp"
MOST_SESSIONS = 16
"""One more ends the session whose newest request is the oldest: its client must begin again."""
_SESSION = b"mcp-session-id"
_REFUSED = 400
_FRAMES = FrameRate(long_run_s=1.0, most=1)
"""There are no WebSockets."""


class NewestSessions:
    """Keeps the newest sessions of an application, so that `stop` always finds room for one.

    Args:
        app: Serves Streamable HTTP, without a limit of sessions.
    """

    def __init__(self, app: App) -> None:
        self._app = app
        self._open: dict[bytes, None] = {}
        """By their newest request, the oldest first."""

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request; end the oldest session for a new one."""
        named = dict(scope["headers"]).get(_SESSION)
        if named in self._open:
            del self._open[named]
            if scope["method"] != "DELETE":
                self._open[named] = None

        async def note(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start" and named is None:
                opened = dict(message["headers"]).get(_SESSION)
                if opened is not None and message["status"] < _REFUSED:
                    await self._admit(opened, scope)
            await send(message)

        await self._app(scope, receive, note)

    async def _admit(self, opened: bytes, scope: Scope) -> None:
        self._open[opened] = None
        if len(self._open) > MOST_SESSIONS:
            oldest = next(iter(self._open))
            del self._open[oldest]
            ending = {**scope, "method": "DELETE", "headers": [(_SESSION, oldest)]}
            await self._app(ending, _nothing, _unheard)


async def _nothing() -> MutableMapping[str, Any]:
    return {"type": "http.request", "body": b"", "more_body": False}


async def _unheard(_: MutableMapping[str, Any]) -> None:
    pass


async def serve_stdio(server: MCPServer[Any], beside: Coroutine[Any, Any, None]) -> None:
    """Serve the client that has started this process, until it closes the input."""
    await _beside(server.run_stdio_async(), beside)


async def serve_http(
    server: MCPServer[Any], port: int, say: Callable[[str], None], beside: Coroutine[Any, Any, None]
) -> None:
    """Serve Streamable HTTP to clients of this machine that know the link.

    Raises:
        BtMissionError: The port is in use.
    """
    listener = listening_socket(LOOPBACK, port)
    token = secrets.token_urlsafe(16)
    app = server.streamable_http_app(
        streamable_http_path=PATH,
        max_request_body_size=4 * LONGEST_CALL,
        max_sessions=None,  # a client that cannot open one could not stop the robot
        # The gate below checks the names by which clients call the server, and its token.
        transport_security=TransportSecuritySettings(enable_dns_rebinding_protection=False),
    )
    connections = Connections()
    gate = TokenGate(NewestSessions(app), token, LOOPBACK, connections.admitted)
    guarded = GuardedServer(gate, connections, _FRAMES, most_bytes=1)
    say(f"for agents: http://{LOOPBACK}:{listener.getsockname()[1]}/{token}{PATH}")
    with closing(listener):
        async with server.session_manager.run():
            await _beside(guarded.serve([listener]), beside)


async def _beside(main: Coroutine[Any, Any, None], other: Coroutine[Any, Any, None]) -> None:
    """Run two coroutines until the first ends; an exception of either is raised."""
    tasks = [asyncio.create_task(main), asyncio.create_task(other)]
    try:
        done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        for task in done:
            task.result()
    finally:
        for task in tasks:
            task.cancel()
            with suppress(asyncio.CancelledError):
                await task
