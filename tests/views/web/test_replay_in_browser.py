"""The served page of a recording in a browser: where it opens, and how the run is forked."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import replace
from typing import Any

import pytest

from bt_mission.views.web.report.page import robot_runs, served_page_of
from bt_mission.views.web.server import PageServer
from tests.support.browser import IN_BROWSER, Page
from tests.support.recordings import recording
from tests.support.web_pages import ANY_PORT, play_with
from tests.support.web_scenes import played
from tests.support.web_screen import Screen

pytestmark = IN_BROWSER

COMMAND = "bt-mission fork 'my run.mcap' --at"
SELECTED = (
    "(() => { const box = document.getElementById('fork-command');"
    " return box.value.slice(box.selectionStart, box.selectionEnd); })()"
)
SHOWN = "document.getElementById('fork-command').value"


@pytest.fixture
def play(chromium: Page) -> Callable[..., None]:
    """Play a scene on the page of a recording; nothing may go wrong on it.

    Its options are data of the page besides the recording.
    """

    def play(scene: Callable[[Screen], Awaitable[None]], **more: Any) -> None:
        runs = [replace(run, data={**run.data, **more}) for run in robot_runs(recording())]

        async def visited(server: PageServer) -> None:
            screen = Screen(chromium)
            await screen.visit(server.link)
            await screen.until("document.querySelectorAll('.row').length >= 4")
            await scene(screen)
            assert chromium.problems == []

        play_with(PageServer(served_page_of(runs), ANY_PORT), visited)

    return play


async def go(screen: Screen, at: float) -> None:
    """Move to an instant, by the slider."""
    await screen.slide(at)
    await screen.shows("at", f"{at:.2f} of")


@played("play", at=1.25, speed=4.0)
async def test_it_opens_where_it_is_wanted_and_plays_at_its_pace(screen: Screen) -> None:
    """It stands still until somebody plays it."""
    await screen.shows("at", "1.25 of")
    await screen.shows("at", "paused 4 x")
    await screen.shows("status", "running")
    await screen.look("document.getElementById('follow').focus()")
    await screen.key("p")
    await screen.shows("play", "Pause")
    await screen.key("p")
    await screen.until("document.getElementById('play').innerText.trim() === 'Play'")
    await screen.key("d")  # the tree as a drawing, with the statuses of the instant
    await screen.until("document.querySelector('#drawing .ran-running') !== null")


@played("play", at=0.0, fork={"command": COMMAND, "refusal": ""})
async def test_the_command_for_a_fork_is_that_of_the_instant(screen: Screen) -> None:
    """It stands still for it, and goes along with whoever moves on; a button copies it."""
    await screen.click("play")
    await screen.shows("play", "Pause")
    await screen.key("F")
    await screen.shows("play", "Play")
    await go(screen, 1.25)
    await screen.until(f"{SHOWN} === {COMMAND + ' 1.250'!r}")
    await screen.look("document.getElementById('fork-command').select()")
    assert await screen.look(SELECTED) == await screen.look(SHOWN)
    await screen.look("document.getElementById('fork-command').focus()")
    await go(screen, 2.5)
    await screen.until(f"{SHOWN} === {COMMAND + ' 2.500'!r}")
    await screen.look(
        "Object.defineProperty(navigator, 'clipboard', { configurable: true,"
        " value: { writeText: async (text) => { window.copied = text; } } })"
    )
    await screen.click("fork-copy")
    await screen.shows("notice", "copied")
    assert await screen.look("window.copied") == f"{COMMAND} 2.500"
    await screen.look("Object.defineProperty(navigator, 'clipboard', { value: undefined })")
    await screen.click("fork-copy")
    await screen.shows("notice", "press Ctrl-C")
    assert await screen.look(SELECTED) == f"{COMMAND} 2.500"
    await screen.key("Escape")
    await screen.until("document.getElementById('fork-panel').hidden")
    assert await screen.look("document.activeElement.id") == "fork"


@played("play", fork={"command": COMMAND, "refusal": "a live run cannot run again"})
async def test_a_run_that_cannot_run_again_says_why(screen: Screen) -> None:
    """In the place of the command."""
    await screen.click("fork")
    await screen.shows("notice", "a live run cannot run again")
    assert await screen.look("document.getElementById('fork-panel').hidden")


@played("play")
async def test_where_no_forks_are_offered_there_is_no_button(screen: Screen) -> None:
    """Nor does its key do anything."""
    await screen.until("document.getElementById('fork').offsetParent === null")
    await screen.key("F")
    assert await screen.look("document.getElementById('fork-panel').hidden")
