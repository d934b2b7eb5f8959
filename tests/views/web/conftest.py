"""A mission that is shown to pages, which needs the extra ``web``."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from importlib.util import find_spec

import pytest

from bt_mission.views.web.live import LiveMission
from tests.support.browser import Page
from tests.support.watched import ScriptedExecutive, ScriptedGraph
from tests.support.web_screen import Screen

NEEDED = ("starlette", "uvicorn", "websockets")
SERVING = [
    "test_gate.py",
    "test_guard.py",
    "test_server.py",
    "test_run.py",
    "test_in_browser.py",
    "test_panels_in_browser.py",
    "test_replay_in_browser.py",
]

collect_ignore_glob = [] if all(find_spec(name) for name in NEEDED) else SERVING


@pytest.fixture
def shown(executive: ScriptedExecutive) -> LiveMission:
    """It, for pages."""
    return LiveMission(ScriptedGraph(executive))


@pytest.fixture
def on_page(
    chromium: Page, shown: LiveMission
) -> Callable[[Callable[[Screen], Awaitable[None]]], None]:
    """Play a scene on the page of the scripted executive; nothing may go wrong on it."""
    from bt_mission.views.web.server import WebOptions, WebServer  # noqa: PLC0415 - the extra
    from tests.support.web_pages import serve  # noqa: PLC0415 - as above

    def play(
        scene: Callable[[Screen], Awaitable[None]], *, width: int = 1200, is_read_only: bool = False
    ) -> None:
        async def visited(server: WebServer) -> None:
            screen = Screen(chromium)
            await screen.visit(server.link, width)
            await screen.until("document.querySelectorAll('.row').length >= 5")
            await scene(screen)
            await screen.look("document.body.remove()")

        serve(shown, visited, WebOptions(port=0, is_read_only=is_read_only))
        assert chromium.problems == []

    return play
