"""A recording on the page in a browser: how one moves in it, and how it is forked."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

import pytest

from bt_mission.recording.replay.player import Player
from bt_mission.recording.replay.timeline import read_timeline
from bt_mission.views.web.replay import ForkOffer, ReplayedMission
from bt_mission.views.web.server import WebOptions, WebServer
from tests.support.browser import BROWSER, Page
from tests.support.recordings import recording
from tests.support.web_pages import serve
from tests.support.web_screen import Screen

pytestmark = [
    pytest.mark.process,
    pytest.mark.skipif(BROWSER is None, reason="no Chromium is installed"),
]

COMMAND = "bt-mission fork 'my run.mcap' --at"
SELECTED = (
    "(() => { const box = document.getElementById('fork-command');"
    " return box.value.slice(box.selectionStart, box.selectionEnd); })()"
)
SHOWN = "document.getElementById('fork-command').value"


def play(
    page: Page,
    scene: Callable[[Screen, Player], Awaitable[None]],
    fork: ForkOffer | None,
    *,
    is_read_only: bool = False,
) -> None:
    """Play a scene on the page of a recording; nothing may go wrong on it."""
    player = Player(read_timeline(recording()))

    async def visited(server: WebServer) -> None:
        screen = Screen(page)
        await screen.visit(server.link)
        await screen.until("document.querySelectorAll('.row').length >= 4")
        await scene(screen, player)
        assert page.problems == []

    options = WebOptions(port=0, is_read_only=is_read_only)
    serve(ReplayedMission(player, fork), visited, options)
    page.visit("about:blank", width=800, height=600)


def test_it_is_moved_in_by_buttons_and_keys(chromium: Page):
    """From change to change, to the next start of a node, and at its pace."""

    async def scene(screen: Screen, player: Player) -> None:
        await screen.click("change-on")
        await screen.until("document.getElementById('change-back').disabled === false")
        while player.at_s == 0.0:
            await screen.look("0")
        first_s = player.at_s
        await screen.key("s")
        while player.at_s == first_s:
            await screen.look("0")
        await screen.key("S")
        while player.at_s != first_s:
            await screen.look("0")
        await screen.look("document.getElementById('follow').focus()")
        await screen.key("p")
        await screen.shows("play", "Pause")
        await screen.key("p")
        await screen.until("document.getElementById('play').innerText.trim() === 'Play'")

    play(chromium, scene, None)


def test_the_command_for_a_fork_is_that_of_the_instant(chromium: Page):
    """It stands still for it, and goes along with whoever moves on; a button copies it."""

    async def scene(screen: Screen, player: Player) -> None:
        player.go(1.25)
        await screen.shows("at", "1.25 of")
        player.play()
        await screen.shows("play", "Pause")
        await screen.key("F")
        await screen.shows("play", "Play")
        assert not player.is_playing
        await screen.until(f"{SHOWN} === {COMMAND + f' {player.at_s:.3f}'!r}")
        focused = "document.activeElement.id"
        assert await screen.look(focused) == "fork-command"
        assert await screen.look(SELECTED) == await screen.look(SHOWN)
        player.go(2.5)
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
        assert await screen.look(focused) == "fork"

    play(chromium, scene, ForkOffer(COMMAND))


def test_a_run_that_cannot_run_again_says_why(chromium: Page):
    """In the place of the command."""

    async def scene(screen: Screen, _: Player) -> None:
        await screen.click("fork")
        await screen.shows("notice", "a live run cannot run again")
        assert await screen.look("document.getElementById('fork-panel').hidden")

    play(chromium, scene, ForkOffer(COMMAND, "a live run cannot run again"))


@pytest.mark.parametrize("is_read_only", [False, True])
def test_where_no_forks_are_offered_there_is_no_button(
    chromium: Page,
    is_read_only: bool,  # noqa: FBT001 - a parameter of the test
):
    """Nor does its key do anything; on a page that may only look least of all."""

    async def scene(screen: Screen, _: Player) -> None:
        await screen.until("document.getElementById('fork').offsetParent === null")
        await screen.key("F")
        assert await screen.look("document.getElementById('fork-panel').hidden")

    offer = ForkOffer(COMMAND) if is_read_only else None
    play(chromium, scene, offer, is_read_only=is_read_only)
