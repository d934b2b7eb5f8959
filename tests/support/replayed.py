"""A recording on a terminal that the test holds; time passes when the test says so."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

from textual.pilot import Pilot

from bt_mission.recording.replay.player import Player
from bt_mission.recording.replay.timeline import read_timeline
from bt_mission.views.terminal.marks import SIGNS, Marks
from bt_mission.views.tui.replay_app import Fork, ReplayApp
from tests.support.recordings import recording
from tests.support.screens import as_test


class Replayed:
    """The view of a recording that stands still."""

    def __init__(self, app: ReplayApp, pilot: Pilot[None]) -> None:
        self.app = app
        self.pilot = pilot

    @property
    def player(self) -> Player:
        return self.app.player

    async def press(self, *keys: str) -> None:
        """Press keys, one after another."""
        for key in keys:
            await self.pilot.press(key)
        await self.pilot.pause()

    async def type(self, text: str) -> None:
        """Type a text, and Enter."""
        await self.press(*("full_stop" if letter == "." else letter for letter in text), "enter")

    async def show(self, at_s: float) -> None:
        """Go to a time, without a key."""
        self.player.go(at_s)
        self.app.draw()
        await self.pilot.pause()

    @property
    def rows(self) -> list[str]:
        """What stands on the terminal, without blanks at the ends of lines."""
        strips = self.app.screen._compositor.render_strips()
        return [strip.text.rstrip() for strip in strips]

    @property
    def text(self) -> str:
        return "\n".join(self.rows)


def on_replay(
    play: Callable[[Replayed], Awaitable[None]],
    *,
    size: tuple[int, int] = (80, 24),
    marks: Marks = SIGNS,
    path: Any = None,
    fork: Fork | None = None,
    **options: Any,
) -> None:
    """Play a scene on a view of this size, of the short mission or another file."""
    player = Player(read_timeline(path or recording()), **options)

    async def scene() -> None:
        app = ReplayApp(player, marks, fork)
        async with app.run_test(size=size) as pilot:
            await pilot.pause()
            app.draw()
            await pilot.pause()
            await play(Replayed(app, pilot))

    asyncio.run(scene())


def replayed(**options: Any) -> Callable[[Callable[..., Awaitable[None]]], Callable[..., None]]:
    """Make a scene on the view of a recording a test."""
    return as_test(on_replay, options)
