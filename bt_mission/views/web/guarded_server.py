"""A web server that limits the effect of its clients on the process.

The number of connections is bounded where they are accepted. A connection without a valid request
is closed after two seconds, or for a newer one if there is no room. Malformed requests get a
response of 4xx, and no line in the log. The frames of a WebSocket are counted.
"""

from __future__ import annotations

import asyncio
import errno
import logging
import resource
import socket
from collections.abc import Generator, Iterator, MutableMapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from bt_mission.base.errors import BtMissionError
from bt_mission.base.wall_clock import Stopwatch

MOST_CONNECTIONS = 64
"""Connections that are open at once, where the limit of open files allows for them."""

FILES_SHARE = 4
"""Connections take at most the process's limit of open files divided by this."""

REQUEST_S = 2.0
"""Wall time after which a connection without a valid request is closed."""

KEEP_ALIVE_S = 5.0
"""Wall time after a response until a connection is closed without another request."""

PASSES = 8
"""A pass of the event loop accepts at most the room divided by this. A request is found valid five
passes after its connection was accepted: before newer connections can have taken all the room.
"""

NO_FILES_S = 0.5
"""Wall time until the next connection is accepted if the process has no open files left."""

LONGEST_HEAD = 8_000
"""Bytes of a request that wait for the end of its headers."""

NEXT_PORTS = 20
"""Ports after an occupied one that are tried."""

TOO_MUCH = 1008
"""The code (policy violation) with which a WebSocket is closed that sends more."""

LINGER_S = 1.0
"""Wall time for which frames are skipped until such a client has left."""

BAD_REQUEST = b"HTTP/1.1 400 Bad Request\r\nConnection: close\r\nContent-Length: 0\r\n\r\n"

Scope = MutableMapping[str, Any]


@dataclass(frozen=True)
class FrameRate:
    """Frames that a client of a WebSocket may send: messages, fragments, pings and pongs.

    Attributes:
        long_run_s: In a second, in the long run.
        most: At once.
    """

    long_run_s: float
    most: int


class _Config(uvicorn.Config):
    """Uvicorn's settings, which its protocols get, with our own."""

    frames: FrameRate


class Connection:
    """An accepted connection: open until its socket is closed."""

    def __init__(self, accepted: socket.socket, peer: tuple[str, int]) -> None:
        self.socket, self.peer = accepted, peer
        self.transport: asyncio.Transport | None = None
        self.is_admitted = False
        """Whether it has sent a valid request."""
        self._deadline: asyncio.TimerHandle | None = None
        self._is_aborted = False

    def serve_on(self, transport: asyncio.Transport) -> None:
        """Use a transport, or close it if the connection was to be closed before it was there."""
        self.transport = transport
        if self._is_aborted:
            transport.abort()

    @property
    def is_open(self) -> bool:
        """Whether it uses a file of the process."""
        return self.socket.fileno() >= 0

    def close_after(self, wait_s: float) -> None:
        """Close it then, unless a request of it is served until then."""
        self.stay()
        self._deadline = asyncio.get_running_loop().call_later(wait_s, self.abort)

    def stay(self) -> None:
        """Cancel the deadline, if there is one."""
        if self._deadline is not None:
            self._deadline.cancel()

    def abort(self) -> None:
        """Close it, without sending what has not been sent."""
        self.stay()
        self._is_aborted = True
        if self.transport is not None and self.is_open:  # asyncio cannot abort a closed one
            self.transport.abort()


class Connections:
    """Those that are open, the oldest first.

    Attributes:
        most: How many there may be.
    """

    def __init__(self) -> None:
        files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
        is_bounded = files != resource.RLIM_INFINITY
        self.most = min(MOST_CONNECTIONS, files // FILES_SHARE) if is_bounded else MOST_CONNECTIONS
        self._open: list[Connection] = []

    def __len__(self) -> int:
        return sum(connection.is_open for connection in self._open)

    def take(self, accepted: socket.socket, peer: tuple[str, int]) -> Connection | None:
        """Return a new connection.

        Without room, the oldest without a valid request is closed for it. If all have sent one, the
        new one is closed, and None returned.
        """
        self._open = [known for known in self._open if known.is_open]
        if len(self._open) >= self.most and not self._make_room():
            accepted.close()
            return None
        connection = Connection(accepted, peer)
        self._open.append(connection)
        return connection

    def _make_room(self) -> bool:
        for connection in self._open:
            if not connection.is_admitted and connection.transport is not None:
                connection.abort()
                self._open.remove(connection)
                return True
        return False

    @contextmanager
    def admitted(self, scope: Scope) -> Iterator[None]:
        """Keep the connection of a valid request open while it is served, and a while longer."""
        connections = [
            connection
            for connection in self._open
            if connection.peer == tuple(scope["client"] or ())
        ]
        for connection in connections:
            connection.is_admitted = True
            connection.stay()
        try:
            yield
        finally:
            for connection in connections:
                connection.close_after(KEEP_ALIVE_S)


class GuardedServer(uvicorn.Server):
    """Serves an ASGI application on a socket; the caller handles signals.

    Args:
        app: Calls :meth:`Connections.admitted` for each request that it serves.
        connections: The connections.
        frames: The rate of a WebSocket client's frames.
        most_bytes: The limit of a WebSocket message.
    """

    def __init__(
        self, app: Any, connections: Connections, frames: FrameRate, *, most_bytes: int
    ) -> None:
        config = _Config(
            app,
            lifespan="off",
            http=_Http,
            ws=_WebSocket,
            ws_max_size=most_bytes,
            ws_per_message_deflate=False,
            h11_max_incomplete_event_size=LONGEST_HEAD,
            timeout_keep_alive=int(KEEP_ALIVE_S),
            log_config=None,
            log_level=logging.CRITICAL + 1,
            access_log=False,
            server_header=False,
            timeout_graceful_shutdown=1,
        )
        config.frames = frames
        config.load()  # imports, too, which would be taken from the mission's time later
        super().__init__(config)
        self._connections = connections
        self._tasks: set[asyncio.Task[None]] = set()

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Accept connections, and no more than there is room for."""
        assert sockets, "it serves the socket of its caller"
        (self._listener,) = sockets
        self._listener.setblocking(False)
        await self.lifespan.startup()
        self.servers: list[asyncio.Server] = []
        self._listen()
        self.started = True

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Accept no more, and end what is open."""
        asyncio.get_running_loop().remove_reader(self._listener)
        await super().shutdown(sockets)

    @contextmanager
    def capture_signals(self) -> Generator[None, None, None]:
        """Capture no signals."""
        yield

    def _listen(self) -> None:
        if not self.should_exit:
            asyncio.get_running_loop().add_reader(self._listener, self._accept)

    def _accept(self) -> None:
        loop = asyncio.get_running_loop()
        for _ in range(max(1, self._connections.most // PASSES)):
            try:
                accepted, address = self._listener.accept()
            except (BlockingIOError, InterruptedError, ConnectionAbortedError):
                return
            except OSError:
                loop.remove_reader(self._listener)
                loop.call_later(NO_FILES_S, self._listen)
                return
            connection = self._connections.take(accepted, address[:2])
            if connection is not None:
                connection.close_after(REQUEST_S)
                task = loop.create_task(self._serve_on(connection))
                self._tasks.add(task)
                task.add_done_callback(self._tasks.discard)

    async def _serve_on(self, connection: Connection) -> None:
        try:
            transport, _ = await asyncio.get_running_loop().connect_accepted_socket(
                lambda: _Http(self.config, self.server_state, self.lifespan.state),
                connection.socket,
            )
        except OSError:
            connection.socket.close()
        else:
            connection.serve_on(transport)


class _Http(H11Protocol):
    """HTTP, and the beginning of each WebSocket."""

    def data_received(self, data: bytes) -> None:
        """Handle received data; an error of the libraries closes the connection."""
        try:
            super().data_received(data)
        except Exception:  # noqa: BLE001 - the event loop would log it, once for each connection
            self.transport.abort()


class _WebSocket(WebSocketsSansIOProtocol):
    """A WebSocket on which all frames are counted."""

    def __init__(self, *args: Any, **named: Any) -> None:
        super().__init__(*args, **named)
        self._frames: FrameRate = self.config.frames
        self._left = float(self._frames.most)
        self._since = Stopwatch()

    def data_received(self, data: bytes) -> None:
        """Handle received data; a request that cannot be read gets a response of 4xx."""
        try:
            super().data_received(data)
        except Exception:  # noqa: BLE001 - as for HTTP
            self.transport.abort()
        if self.conn.handshake_exc is not None and not self.handshake_initiated:
            self.transport.write(b"".join(self.conn.data_to_send()) or BAD_REQUEST)
            self.transport.close()

    def handle_events(self) -> None:
        """Take frames, as many as are permitted."""
        events = self.conn.events
        count = len(events)
        gained = self._since.elapsed_s * self._frames.long_run_s
        self._left = min(self._left + gained, self._frames.most)
        self._since = Stopwatch()
        del events[int(self._left) :]
        self._left -= len(events)
        is_too_much = len(events) < count
        super().handle_events()
        if is_too_much and not self.transport.is_closing():
            reason = f"more than {self._frames.long_run_s:g} messages a second"
            self.queue.put_nowait(
                {"type": "websocket.disconnect", "code": TOO_MUCH, "reason": reason}
            )
            self.conn.fail(TOO_MUCH, reason)
            self.transport.write(b"".join(self.conn.data_to_send()))
            self.close_sent = True
            # Closed at once, with frames that have not been read, TCP would take the reason back.
            self.transport.write_eof()
            self.close_timer = self.loop.call_later(LINGER_S, self.transport.close)


def listening_socket(host: str, port: int, option: str = "--port") -> socket.socket:
    """Return a listening socket.

    Args:
        option: The command-line option that names the port.

    Raises:
        BtMissionError: The port is occupied, with a free one.
    """
    try:
        return _bound(host, port)
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            free = next(_free_ports(host, port), None)
            hint = f"{option} {free} is free" if free else f"{option} 0 uses any free port"
            raise BtMissionError(
                f"{option} {port}: the port is in use; {hint}", code="BT-910"
            ) from None
        if error.errno in (errno.EACCES, errno.EPERM):
            raise BtMissionError(
                f"{option} {port}: no permission for this port; use 1024 or above", code="BT-910"
            ) from None
        raise BtMissionError(
            f"--host {host}: cannot listen on this address ({error.strerror or error}); use an "
            f"address of this machine, such as 127.0.0.1",
            code="BT-910",
        ) from None


def _bound(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((host, port))
        listener.listen(64)
    except BaseException:
        listener.close()
        raise
    return listener


def _free_ports(host: str, port: int) -> Iterator[int]:
    for number in range(port + 1, min(port + 1 + NEXT_PORTS, 65536)):
        try:
            _bound(host, number).close()
        except OSError:
            continue
        yield number
