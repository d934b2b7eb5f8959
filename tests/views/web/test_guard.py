"""The server with more connections than it has room for, and with malformed requests."""

from __future__ import annotations

import asyncio
import resource
import socket
from contextlib import suppress

import pytest
from websockets.frames import Frame, Opcode

from bt_mission.views.web import guarded_server
from bt_mission.views.web.guarded_server import MOST_CONNECTIONS, Connection, Connections
from bt_mission.views.web.live import LiveMission
from bt_mission.views.web.server import WebServer
from tests.support.watched import ScriptedExecutive
from tests.support.web_pages import PageModel, closed, fetch, live, serve
from tests.support.web_scenes import served


async def raw(server: WebServer, sent: bytes) -> bytes:
    """What the server answers to these bytes until it closes the connection."""
    reader, writer = await asyncio.open_connection("127.0.0.1", server.port)
    writer.write(sent)
    answer = b""
    with suppress(ConnectionError):
        answer = await reader.read()
    writer.close()
    return answer


@served
async def test_silent_connections_make_room_for_those_with_the_token(server: WebServer) -> None:
    """The oldest are closed; a page with its WebSocket opens, and stays while more come."""
    silent = [await asyncio.open_connection("127.0.0.1", server.port) for _ in range(200)]
    status, _, _ = await fetch(server, f"/{server.token}/")
    assert status == 200
    async with live(server) as connection:
        page = PageModel(connection)
        silent += [await asyncio.open_connection("127.0.0.1", server.port) for _ in range(200)]
        await page.until(lambda it: it.nodes)
        await page.settle()
    for reader, _ in silent[: 400 - MOST_CONNECTIONS]:
        with suppress(ConnectionError):
            assert await reader.read() == b""
    for _, writer in silent:
        writer.close()


def test_no_more_connections_are_open_than_there_is_room_for(
    shown: LiveMission, monkeypatch: pytest.MonkeyPatch
):
    """Where all of them have sent a valid request, the next one is closed at once."""
    monkeypatch.setattr(guarded_server, "MOST_CONNECTIONS", 2)

    async def scene(server: WebServer) -> None:
        async with live(server) as first, live(server) as other:
            for socket in (first, other):
                await PageModel(socket).until(lambda it: it.nodes)
            assert await raw(server, b"GET / HTTP/1.1\r\n") == b""
        assert (await fetch(server, f"/{server.token}/"))[0] == 200

    serve(shown, scene)


@pytest.mark.parametrize("sent", [b"", b"GET /", b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX"])
@served
async def test_a_connection_without_a_whole_request_is_closed(
    server: WebServer, monkeypatch: pytest.MonkeyPatch, sent: bytes
) -> None:
    """Also one that has begun to send it, and one whose time is over before it is served."""
    monkeypatch.setattr(guarded_server, "REQUEST_S", 0.0)
    assert await raw(server, sent) == b""


@served
async def test_a_connection_that_has_been_answered_is_closed_without_another_request(
    server: WebServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A part of the next one does not keep it open."""
    monkeypatch.setattr(guarded_server, "KEEP_ALIVE_S", 0.01)
    path = f"GET /{server.token}/ HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
    answer = await raw(server, path.encode() + b"GET / HTTP/1.1\r\nX")
    assert answer.startswith(b"HTTP/1.1 200")


def test_a_connection_that_has_ended_can_be_aborted() -> None:
    """Such as by its deadline, when the server was busy; asyncio's own transport cannot be."""

    async def scene() -> None:
        loop = asyncio.get_running_loop()
        ours, theirs = socket.socketpair()
        with theirs:
            theirs.setblocking(False)
            ends = asyncio.StreamReaderProtocol(asyncio.StreamReader())
            transport, _ = await loop.connect_accepted_socket(lambda: ends, ours)
            connection = Connection(ours, ("", 0))
            connection.serve_on(transport)
            transport.write(b"x" * 10_000_000)
            transport.close()
            while await loop.sock_recv(theirs, 1_000_000):
                pass
            while connection.is_open:  # noqa: ASYNC110 - the loop closes it in its next passes
                await asyncio.sleep(0)  # noqa: TID251 - lets it
            connection.abort()

    asyncio.run(scene())


@pytest.mark.parametrize(
    ("limit", "most"),
    [(resource.RLIM_INFINITY, MOST_CONNECTIONS), (1024, MOST_CONNECTIONS), (128, 32)],
)
def test_connections_leave_files_to_the_mission(
    monkeypatch: pytest.MonkeyPatch, limit: int, most: int
):
    """They take at most a quarter of what the process may open."""
    monkeypatch.setattr(resource, "getrlimit", lambda _: (limit, limit))
    assert Connections().most == most


UPGRADE = "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
HOST = "Host: 127.0.0.1\r\n"
MANY_HEADERS = "a: b\r\n" * 200


@pytest.mark.parametrize(
    ("request_text", "status"),
    [
        (f"OPTIONS * HTTP/1.1\r\n{HOST}\r\n", 400),
        (f"CONNECT other:443 HTTP/1.1\r\n{HOST}\r\n", 400),
        (f"GET http://127.0.0.1/TOKEN/ HTTP/1.1\r\n{HOST}\r\n", 400),
        (f"GET /TOKEN/{'a' * 300} HTTP/1.1\r\n{HOST}\r\n", 404),
        (f"GET /TOKEN/%00 HTTP/1.1\r\n{HOST}\r\n", 404),
        (f"GET /TOKEN/{'a' * 60_000} HTTP/1.1\r\n{HOST}\r\n", 404),
        (f"GET /TOKEN/{'a' * 20_000}", 400),
        (f"GET /TOKEN/{'a' * 60_000} HTTP/1.1\r\n{HOST}{UPGRADE}\r\n", 414),
        (f"GET /TOKEN/live HTTP/1.1\r\n{HOST}{UPGRADE}X: {'a' * 60_000}\r\n\r\n", 431),
        (f"GET /TOKEN/%ff%fe HTTP/1.1\r\n{HOST}\r\n", 404),
        (f"POST /TOKEN/ HTTP/1.1\r\n{HOST}Content-Length: 1\r\n\r\nx", 405),
        (f"POST / HTTP/1.1\r\n{HOST}Content-Length: 999999999\r\n\r\nx", 403),
        (f"GET /TOKEN/ HTTP/1.1\r\n{HOST}Content-Length: {'9' * 400}\r\n\r\n", 400),
        ("GET /TOKEN/ HTTP/1.1\r\n\r\n", 400),
        ("\r\n\r\n\x00\x01 nonsense\r\n\r\n", 400),
        (f"GET /TOKEN/live HTTP/1.1\r\n{HOST}{UPGRADE}\r\n", 400),
        (f"POST /TOKEN/live HTTP/1.1\r\n{HOST}{UPGRADE}\r\n", 405),
        (f"GET /TOKEN/live HTTP/1.1\r\n{HOST}{UPGRADE}Content-Length: 1\r\n\r\nx", 400),
        (f"GET /TOKEN/live HTTP/1.1\r\n{HOST}{UPGRADE}{MANY_HEADERS}\r\n", 431),
        (f"GET * HTTP/1.1\r\n{HOST}{UPGRADE}Sec-WebSocket-Key: {'A' * 22}==\r\n\r\n", 403),
        (f"GET /TOKEN/x HTTP/1.1\r\n{HOST}{UPGRADE}Sec-WebSocket-Key: {'A' * 22}==\r\n\r\n", 403),
    ],
)
def test_malformed_requests_are_refused(
    shown: LiveMission, capfd: pytest.CaptureFixture[str], request_text: str, status: int
):
    """With a status that says that the request is at fault, and without a line in the log."""

    async def scene(server: WebServer) -> None:
        text = request_text.replace("TOKEN", server.token)
        if "Connection" not in text:
            text = text.replace(HOST, f"{HOST}Connection: close\r\n")
        answer = await raw(server, text.encode("latin-1"))
        assert answer[:12].decode() == f"HTTP/1.1 {status}"
        assert (await fetch(server, f"/{server.token}/"))[0] == 200

    serve(shown, scene)
    assert capfd.readouterr() == ("", "")


PING = Frame(Opcode.PING, b"x" * 100)
FLOODS = {
    "pings": (PING, PING),
    "pongs": (Frame(Opcode.PONG, b""),) * 2,
    "empty fragments": (Frame(Opcode.TEXT, b"", fin=False), Frame(Opcode.CONT, b"", fin=False)),
}


@pytest.mark.parametrize("flood", FLOODS)
@served
async def test_frames_of_every_kind_are_bounded(
    server: WebServer, executive: ScriptedExecutive, flood: str
) -> None:
    """A client that sends too many is closed, with a code and a reason; the others stay."""
    first, then = FLOODS[flood]
    async with live(server) as good:
        page = PageModel(good)
        async with live(server) as bad:
            frames = [first.serialize(mask=True)] + [then.serialize(mask=True)] * 1000
            bad.transport.write(b"".join(frames))
            assert await closed(bad) == (1008, "more than 20 messages a second")
        executive.change(1.0, drive="running")
        await page.until(lambda it: it.nodes.get(3, [0, 0])[1] == 1)


@served
async def test_a_text_that_is_none_closes_the_connection(server: WebServer) -> None:
    """With the code for it."""
    async with live(server) as bad:
        bad.transport.write(Frame(Opcode.TEXT, b"\xff\xfe").serialize(mask=True))
        assert (await closed(bad))[0] == 1007
