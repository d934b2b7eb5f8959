"""Scenes on a page and at its server, as tests."""

from __future__ import annotations

import inspect
from collections.abc import Awaitable, Callable
from functools import partial, wraps
from typing import Any

Scene = Callable[..., Awaitable[None]]


def _test_of(scene: Scene, fixture: str, play: Callable[[Any, Scene], None]) -> Callable[..., None]:
    """Return a test that plays a scene with a fixture; its other arguments are fixtures, too."""
    signature = inspect.signature(scene)
    first, *others = signature.parameters.values()
    names = {parameter.name for parameter in others}

    @wraps(scene)
    def test(**fixtures: Any) -> None:
        used = {name: value for name, value in fixtures.items() if name in names}
        play(fixtures[fixture], partial(scene, **used))

    own = [] if fixture in names else [first.replace(name=fixture)]
    test.__signature__ = signature.replace(parameters=[*own, *others])  # type: ignore[attr-defined]
    return test


def served(scene: Scene) -> Callable[..., None]:
    """Make a scene a test: it begins with the server of the mission that is shown."""
    from tests.support.web_pages import serve  # noqa: PLC0415 - needs the extra

    return _test_of(scene, "shown", serve)


def played(fixture: str, **options: Any) -> Callable[[Scene], Callable[..., None]]:
    """Make a scene a test that a fixture plays: it begins with what the fixture passes."""
    return lambda scene: _test_of(scene, fixture, lambda play, it: play(it, **options))


def scene_on_page(**options: Any) -> Callable[[Scene], Callable[..., None]]:
    """Make a scene a test: it begins with the screen of a browser on the page."""
    return played("on_page", **options)
