"""The option of commands that show a simulation in a window, and what it does."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from bt_mission.cli.parser import Option, each

if TYPE_CHECKING:
    from bt_mission.sessions.session import Onlooker, Session


def _check_display() -> None:
    from sim.views.window import check_display

    check_display()


VIEW = Option(
    "--view",
    "show the simulation in the MuJoCo viewer, in real time unless --speed is given",
    excludes=each(
        "attach",
        why="it shows a simulation in this process; add it to `bt-mission sim`, or use "
        "`bt-mission watch`",
    ),
    check=_check_display,
)


def windows(session: Session, *, wanted: bool) -> Iterator[Onlooker]:
    """Yield a window on a session on the stage, if one is wanted. Closing it ends nothing.

    Raises:
        BtMissionError: Where there is no display.
    """
    from bt_mission.sessions.stage import Stage

    if wanted and isinstance(session, Stage):
        from bt_mission.sessions.stage_window import StageWindow

        yield StageWindow(session)
