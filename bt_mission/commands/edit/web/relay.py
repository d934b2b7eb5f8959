"""The connection of a page with the page of a run, which another process serves."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import Any
from urllib.parse import urlsplit

from starlette.websockets import WebSocket, WebSocketDisconnect
from websockets.asyncio.client import connect
from websockets.exceptions import WebSocketException

TRY_LATER = 1013


async def relay(page: WebSocket, link: str) -> None:
    """Connect a page with the WebSocket of a child, until one of them leaves."""
    await page.accept()
    address = urlsplit(link)
    try:
        async with connect(
            f"ws://{address.netloc}{address.path}live",
            origin=f"http://{address.netloc}",
            max_size=None,
            compression=None,
        ) as child:
            tasks = [
                asyncio.create_task(_to_child(page, child)),
                asyncio.create_task(_to_page(page, child)),
            ]
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
    except (OSError, WebSocketException):
        pass
    with suppress(RuntimeError, WebSocketDisconnect):
        await page.close(TRY_LATER)


async def _to_child(page: WebSocket, child: Any) -> None:
    while True:
        await child.send(await page.receive_text())


async def _to_page(page: WebSocket, child: Any) -> None:
    async for message in child:
        if isinstance(message, bytes):
            await page.send_bytes(message)
        else:
            await page.send_text(message)
