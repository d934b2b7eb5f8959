"""MuJoCo's own viewer as an onlooker of the stage."""

from __future__ import annotations

from bt_mission.sessions.session import Onlooker, Session
from bt_mission.sessions.stage import Stage
from sim.views.window import Window


class StageWindow(Onlooker):
    """Shows the simulation of a stage in a window.

    Raises:
        BtMissionError: Where there is no display.
    """

    def __init__(self, stage: Stage) -> None:
        self._window = Window(stage.sim.physics)

    def attach(self, session: Session) -> None:
        """Draw after each tick."""
        session.executive.after_tick.append(self._window.look)

    def close(self) -> None:
        """Close the window."""
        self._window.close()
