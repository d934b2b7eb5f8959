"""Access control of the page: anyone with the link, from a browser that addresses this server.

The token excludes other users of the machine. Any page of the web can have a visitor's browser talk
to this machine, so the addresses that the browser names are checked, too: ``Host`` against names
that were made to point here (DNS rebinding), ``Origin`` against pages of others.
"""

from __future__ import annotations

import ipaddress
import re
import secrets
from collections.abc import Awaitable, Callable, Mapping, MutableMapping
from contextlib import AbstractContextManager
from typing import Any
from urllib.parse import urlsplit

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

OLD_LINK = "This link is invalid or expired: open the link that the command printed.\n"

NO_PATH = "This server serves only its page.\n"

AUTHORITY = re.compile(r"[A-Za-z0-9.\-\[\]:]+")
"""An address or a name with a port, and nothing that would be more in a header."""

HEADERS = {
    "cache-control": "no-store",
    "content-security-policy": "default-src 'none'; script-src 'self'; style-src 'self'; "
    "img-src 'self' data:; connect-src 'self' {socket}; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
}

FRAMED_HEADERS = HEADERS | {
    "content-security-policy": HEADERS["content-security-policy"].replace(
        "frame-ancestors 'none'", "frame-ancestors 'self'; frame-src 'self'"
    ),
    "x-frame-options": "SAMEORIGIN",
}
"""The same for a page that shows another page of its server in a frame."""


class TokenGate:
    """Passes requests with the token and a name of this server on to an application.

    Args:
        app: Gets the token as the root of its paths.
        token: The first part of each path.
        host: The address of the server; a name by which it may be called.
        admitted: The context in which an admitted request is served.
        headers: Those of every answer.
    """

    def __init__(
        self,
        app: App,
        token: str,
        host: str,
        admitted: Callable[[Scope], AbstractContextManager[None]],
        headers: Mapping[str, str] = HEADERS,
    ) -> None:
        self._headers = headers
        self._app = app
        self._token = token
        self._host = host
        self._admitted = admitted

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or let the application do so."""
        if not scope["path"].startswith("/"):
            await _refuse(scope, send, 400, NO_PATH)
            return
        why = self._refusal(scope)
        if why:
            await _refuse(scope, send, 403, why)
            return
        named = _header(scope, "host")

        async def send_guarded(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                more = [
                    (name.encode(), value.format(socket=f"ws://{named}").encode())
                    for name, value in self._headers.items()
                ]
                message = {**message, "headers": [*message.get("headers", ()), *more]}
            await send(message)

        inner = {**scope, "root_path": f"/{self._token}"}
        with self._admitted(scope):
            await self._app(inner, receive, send_guarded)

    def _refusal(self, scope: Scope) -> str:
        """Return why a request is refused; empty if it is not."""
        named = _header(scope, "host")
        if not self._is_ours(named):
            return "This server accepts only its address or localhost.\n"
        given = scope["path"].split("/")[1]
        if not secrets.compare_digest(given.encode(), self._token.encode()):
            return OLD_LINK
        origin = _header(scope, "origin")
        if origin != f"http://{named}" and (origin or scope["type"] == "websocket"):
            return "Requests from pages of other servers are refused.\n"
        return ""

    def _is_ours(self, named: str) -> bool:
        """Return whether a browser calls this server by an address.

        An address cannot be redirected.
        """
        if not AUTHORITY.fullmatch(named):
            return False
        try:
            host = urlsplit(f"//{named}").hostname or ""
        except ValueError:
            return False
        if host in ("localhost", self._host):
            return True
        try:
            address = ipaddress.ip_address(host)
        except ValueError:
            return False
        return address.is_loopback or not is_loopback(self._host)


def is_loopback(host: str) -> bool:
    """Return whether an address, or a name, cannot be reached by other machines."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _header(scope: Scope, name: str) -> str:
    values = [value for key, value in scope["headers"] if key == name.encode()]
    return values[0].decode("latin-1") if len(values) == 1 else ""


async def _refuse(scope: Scope, send: Send, status: int, why: str) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008, "reason": why.strip()})
        return
    headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"connection", b"close")]
    headers += [
        (name.encode(), value.encode()) for name, value in HEADERS.items() if "{" not in value
    ]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": why.encode()})
