"""A watcher's view on a terminal that the test holds: keys in, rows of text out."""

from __future__ import annotations

import asyncio
import inspect
from collections.abc import Awaitable, Callable
from functools import partial, wraps
from typing import Any

from textual.pilot import Pilot

from bt_mission.views.terminal.marks import SIGNS, Marks
from bt_mission.views.tui.app import WatchApp
from tests.support.watched import ScriptedExecutive, ScriptedGraph, begun


class Screen:
    """The view of a scripted executive."""

    def __init__(self, app: WatchApp, pilot: Pilot[None], graph: ScriptedGraph) -> None:
        self.app = app
        self.pilot = pilot
        self.graph = graph

    @property
    def executive(self) -> ScriptedExecutive:
        return self.graph.executives[0]

    async def look(self) -> None:
        """Let the view take what the executive tells."""
        self.app.look()
        await self.pilot.pause()
        self.app.look()  # with what it has asked for
        await self.pilot.pause()

    async def press(self, *keys: str) -> None:
        """Press keys, one after another."""
        for key in keys:
            await self.pilot.press(key)
        await self.pilot.pause()

    @property
    def rows(self) -> list[str]:
        """What stands on the terminal, without blanks at the ends of lines."""
        strips = self.app.screen._compositor.render_strips()
        return [strip.text.rstrip() for strip in strips]

    @property
    def text(self) -> str:
        return "\n".join(self.rows)

    @property
    def chosen(self) -> str:
        """The row that is selected in the tree."""
        (row,) = (row for row in self.rows if row.startswith(SIGNS.cursor))
        return row[2:].strip()


def on_screen(
    play: Callable[[Screen], Awaitable[None]],
    *executives: ScriptedExecutive,
    make: Callable[[], ScriptedExecutive] = begun,
    size: tuple[int, int] = (80, 24),
    marks: Marks = SIGNS,
    **options: Any,
) -> None:
    """Play a scene on a view of this size.

    Args:
        make: Makes the executive, where none is passed.
    """
    graph = ScriptedGraph(*(executives or (make(),)))

    async def scene() -> None:
        app = WatchApp(graph, marks, **options)
        async with app.run_test(size=size) as pilot:
            screen = Screen(app, pilot, graph)
            await pilot.pause()
            await screen.look()
            await play(screen)

    asyncio.run(scene())


def as_test(
    play: Callable[..., None], options: dict[str, Any]
) -> Callable[[Callable[..., Awaitable[None]]], Callable[..., None]]:
    """Return a decorator that plays scenes with options; their other arguments are fixtures."""

    def decorate(scene: Callable[..., Awaitable[None]]) -> Callable[..., None]:
        @wraps(scene)
        def test(**fixtures: Any) -> None:
            play(partial(scene, **fixtures), **options)

        signature = inspect.signature(scene)
        parameters = tuple(signature.parameters.values())[1:]
        test.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
        return test

    return decorate


def shown(**options: Any) -> Callable[[Callable[..., Awaitable[None]]], Callable[..., None]]:
    """Make a scene on a screen a test."""
    return as_test(on_screen, options)
