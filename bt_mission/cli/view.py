"""The option of commands that show a simulation in a window, and what it does."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager
from typing import TYPE_CHECKING

from bt_mission.cli.parser import Option, each

if TYPE_CHECKING:
    from bt_mission.sessions.session import ObservableSession


def _check_display() -> None:
    from sim.views.window import check_display

    check_display()


VIEW = Option(
    "--view",
    "show the simulation in MuJoCo's own viewer, in real time unless --speed says else",
    excludes=each(
        "attach",
        why="it shows a simulation in this process; add it to `bt-mission sim`, or look on with "
        "`bt-mission watch`",
    ),
    check=_check_display,
)


@contextmanager
def window_on(session: ObservableSession, *, wanted: bool) -> Iterator[None]:
    """A window on a session on the stage, if one is wanted, which looks on after each tick.

    Who closes it ends nothing but the looking on.

    Raises:
        BtMissionError: Where there is no display.
    """
    from bt_mission.sessions.stage import Stage

    if not wanted or not isinstance(session, Stage):
        yield
        return
    from sim.views.window import Window

    after_tick = session.executive.after_tick
    with closing(Window(session.sim.physics)) as window:
        after_tick.append(window.look)
        try:
            yield
        finally:
            after_tick.remove(window.look)
