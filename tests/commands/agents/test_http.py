"""Streamable HTTP on this machine, with the client of the SDK."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any
from urllib.parse import urlsplit

import httpx2
import pytest
from mcp.client import Client
from mcp_types import Implementation

from bt_mission.commands.agents.transports import MOST_SESSIONS, serve_http
from tests.commands.agents.played import TURN, Played

PING = {"jsonrpc": "2.0", "id": 1, "method": "ping"}
JSON = {"Accept": "application/json, text/event-stream", "Content-Type": "application/json"}


def over_http(played: Played, scene: Callable[[str], Awaitable[None]]) -> None:
    """Serve on a free port while a scene is played; it gets the link."""

    async def play() -> None:
        link: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        never: asyncio.Future[None] = asyncio.get_running_loop().create_future()

        async def beside() -> None:
            await never

        def say(text: str) -> None:
            link.set_result(text.removeprefix("for agents: "))

        serving = asyncio.create_task(serve_http(played.server, 0, say, beside()))
        try:
            await asyncio.wait_for(scene(await link), 60)
        finally:
            never.set_result(None)
            await serving

    asyncio.run(play())


def test_a_client_with_the_link_proposes_and_stops(played: Played) -> None:
    """The log has the name that the client gives itself."""

    async def scene(link: str) -> None:
        me = Implementation(name="planner", version="3")
        async with Client(link, client_info=me) as client:
            assert "drive" in [tool.name for tool in (await client.list_tools()).tools]
            proposed = await client.call_tool("propose", {"name": "look", "text": TURN})
            assert proposed.structured_content is not None
            assert proposed.structured_content["proposal"] == "look"
            refused = await client.call_tool("drive", {"name": "look"})
            assert "[BT-1404]" in str(refused.content)
            stopped = await client.call_tool("stop", {})
            assert stopped.structured_content == {"is_stopped": True, "why": ""}

    over_http(played, scene)
    assert '"client": "planner 3", "call": "propose"' in played.folder.log.read_text()
    assert played.driven == []


def test_a_client_with_a_wrong_token_reaches_no_tool(played: Played) -> None:
    """There is no line in the log, either."""

    async def scene(link: str) -> None:
        place = f"http://{urlsplit(link).netloc}/{'x' * 22}/mcp"
        with pytest.raises(ExceptionGroup):
            async with Client(place, read_timeout_seconds=5.0) as client:
                await client.call_tool("stop", {})

    over_http(played, scene)
    assert played.robot.stops == 0
    assert played.folder.log.read_text() == ""


OLD = "This link is invalid or expired"
OTHERS = "Requests from pages of other servers are refused"
NAMED = "This server accepts only its address or localhost"


@pytest.mark.parametrize(
    ("path", "headers", "why"),
    [
        ("/mcp", {}, OLD),
        ("/wrong/mcp", {}, OLD),
        ("", {"Origin": "http://evil.example"}, OTHERS),
        ("", {"Origin": "null"}, OTHERS),
        ("", {"Host": "evil.example"}, NAMED),
        ("", {"Host": "evil.example", "Origin": "http://evil.example"}, NAMED),
    ],
)
def test_others_are_refused(played: Played, path: str, headers: dict[str, str], why: str) -> None:
    """Without the token; from a page of another server, or by a name that points here, with it."""

    async def scene(link: str) -> None:
        place = f"http://{urlsplit(link).netloc}{path}" if path else link
        async with httpx2.AsyncClient() as client:
            answer = await client.post(place, json=PING, headers=JSON | headers)
        assert (answer.status_code, why in answer.text) == (403, True)

    over_http(played, scene)
    assert played.folder.log.read_text() == ""


def test_sessions_that_are_left_open_keep_nobody_out(played: Played) -> None:
    """One more ends that whose newest request is the oldest; a new client can stop the robot."""
    me: dict[str, Any] = {"protocolVersion": "2025-06-18", "capabilities": {}}
    me["clientInfo"] = {"name": "a", "version": "1"}
    begin: dict[str, Any] = {"method": "initialize", "params": me}
    stop: dict[str, Any] = {"method": "tools/call", "params": {"name": "stop", "arguments": {}}}

    async def scene(link: str) -> None:
        async with httpx2.AsyncClient() as client:

            async def post(session: str | None = None, **message: Any) -> httpx2.Response:
                more = {} if session is None else {"mcp-session-id": session}
                return await client.post(link, json=PING | message, headers=JSON | more)

            first, second, *_ = [
                (await post(**begin)).headers["mcp-session-id"] for _ in range(MOST_SESSIONS)
            ]
            assert (await post(first)).status_code == 200
            newest = (await post(**begin)).headers["mcp-session-id"]
            assert '"is_stopped":true' in (await post(newest, **stop)).text
            assert [(await post(each)).status_code for each in (first, second)] == [200, 404]

    over_http(played, scene)
