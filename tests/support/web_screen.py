"""A page in a headless browser, for tests that serve it at the same time."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import Any

from tests.support.browser import Page


class Screen:
    """A page that a test looks at while it serves it: its calls leave the loop free."""

    def __init__(self, page: Page) -> None:
        self.page = page

    async def visit(self, link: str, width: int = 1200, height: int = 800) -> None:
        """Open it, and wait until it is connected, or has read its recording."""
        self.page.problems.clear()
        await asyncio.to_thread(partial(self.page.visit, link, width=width, height=height))
        await self.until("document.getElementById('connection').textContent !== 'connecting'")

    async def until(self, expression: str) -> None:
        """Wait until an expression holds."""
        await asyncio.to_thread(self.page.until, expression)

    async def look(self, expression: str) -> Any:
        """The value of an expression."""
        return await asyncio.to_thread(self.page.look, expression)

    async def click(self, name: str) -> None:
        """Click an element by its id."""
        await self.until(f"!document.getElementById({name!r}).disabled")
        await self.look(f"document.getElementById({name!r}).click()")

    async def key(self, key: str) -> None:
        """Press a key."""
        await asyncio.to_thread(self.page.key, key)

    async def shows(self, name: str, text: str) -> None:
        """Wait until an element has this text."""
        await self.until(f"document.getElementById({name!r}).textContent.includes({text!r})")

    async def slide(self, at_s: float) -> None:
        """Move to a time by the slider."""
        await self.look(
            f"(() => {{ const time = document.getElementById('time'); time.value = {at_s};"
            " time.dispatchEvent(new Event('input')); })()"
        )
