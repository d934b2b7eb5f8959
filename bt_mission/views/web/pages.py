"""The open pages: each receives its changes as fast as it reads them."""

from __future__ import annotations

import asyncio
import json
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from bt_mission.views.web import encoding
from bt_mission.views.web.live import LiveMission, OpenPanels
from bt_mission.views.web.page_requests import PageRequest, PageRequestError, read_request

MOST_PAGES = 16

NONSENSE, FAILED, TRY_LATER = 1003, 1011, 1013
"""Codes with which a WebSocket is closed."""

LONGEST_REASON = 100
"""Characters of the reason for which a WebSocket is closed: it takes 123 bytes."""


class OpenPage:
    """One page: the revision it has received, and its open panels.

    Args:
        socket: Accepted already.
        shown: The mission.
        is_read_only: Whether it may only watch.
    """

    def __init__(self, socket: WebSocket, shown: LiveMission, *, is_read_only: bool) -> None:
        self.has_map = self.has_camera = False
        self.changed = asyncio.Event()
        """Set when there may be something to send."""
        self.changed.set()
        self._socket = socket
        self._shown = shown
        self._is_read_only = is_read_only
        self._revision = self._robot_revision = 0
        self._selected: int | None = None
        self._sent_node: dict[str, Any] | None = None
        self._sent_picture = 0
        self._answers: dict[str, Any] = {}

    async def serve(self) -> None:
        """Send and receive until the page is closed, or sends an invalid message."""
        sender = asyncio.create_task(self._send_changes())
        listener = asyncio.create_task(self._listen())
        both = (sender, listener)
        await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
        for task in both:
            task.cancel()
        for fault in await asyncio.gather(*both, return_exceptions=True):
            if isinstance(fault, PageRequestError):
                await self._close(NONSENSE, str(fault))
            elif isinstance(fault, Exception) and not isinstance(fault, WebSocketDisconnect):
                await self._close(FAILED, f"the server failed: {type(fault).__name__}: {fault}")

    async def _close(self, code: int, reason: str) -> None:
        if self._socket.application_state is WebSocketState.CONNECTED:
            await self._socket.close(code, reason[:LONGEST_REASON])

    async def _listen(self) -> None:
        while True:
            self._take(read_request(await self._received()))
            self.changed.set()

    async def _received(self) -> str:
        message = await self._socket.receive()
        if message["type"] == "websocket.disconnect":
            raise WebSocketDisconnect(message.get("code", 1000))
        text = message.get("text")
        if not isinstance(text, str):
            raise PageRequestError("the message is not text")
        return text

    def _take(self, request: PageRequest) -> None:
        match request.do:
            case "select":
                self._selected, self._sent_node = request.node, None
            case "map":
                self.has_map, self._robot_revision = request.is_on, 0
            case "camera":
                self.has_camera, self._sent_picture = request.is_on, 0
            case "series":
                values = self._shown.board.series(request.name)
                self._answers["series"] = encoding.shown([request.name, values])
            case _ if self._is_read_only:
                self._answers["refusal"] = "this view is read-only: start it without --read-only"
            case _:
                self._shown.perform(request)

    async def _send_changes(self) -> None:
        """Send what the page has not received yet, whenever there is more."""
        shown = self._shown
        while True:
            await self.changed.wait()
            self.changed.clear()
            changes, self._answers = self._answers, {}
            if self._revision == 0:
                changes["is_read_only"] = self._is_read_only
            changes |= shown.board.since(self._revision)
            if self.has_map and (robot := shown.board.robot_since(self._robot_revision)):
                changes["robot"] = robot
                self._robot_revision = shown.board.revision
            self._revision = shown.board.revision
            if self._selected is not None:
                node = encoding.node_details(shown.mission, self._selected)
                if node != self._sent_node:
                    changes["node"] = self._sent_node = node
            if changes:
                await self._socket.send_text(json.dumps(changes, allow_nan=False))
            picture = shown.picture
            if self.has_camera and picture is not None and picture[0] > self._sent_picture:
                self._sent_picture = picture[0]
                await self._socket.send_bytes(picture[1])


class OpenPages:
    """All pages that are open.

    Args:
        shown: The mission.
        is_read_only: Whether they may only watch.
    """

    def __init__(self, shown: LiveMission, *, is_read_only: bool) -> None:
        self._shown = shown
        self._is_read_only = is_read_only
        self.all: set[OpenPage] = set()

    @property
    def are_open(self) -> bool:
        """Whether any is open."""
        return bool(self.all)

    @property
    def panels(self) -> OpenPanels:
        """The panels that at least one page has open."""
        return OpenPanels(
            map=any(page.has_map for page in self.all),
            camera=any(page.has_camera for page in self.all),
        )

    async def open(self, socket: WebSocket) -> None:
        """Serve a page until it is closed."""
        await socket.accept()
        if len(self.all) >= MOST_PAGES:
            await socket.close(TRY_LATER, f"{MOST_PAGES} pages are already open")
            return
        page = OpenPage(socket, self._shown, is_read_only=self._is_read_only)
        self.all.add(page)
        try:
            await page.serve()
        finally:
            self.all.discard(page)
