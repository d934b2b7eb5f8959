"""What a server of pages shows, live or from a recording."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from bt_mission.core.stamps import NS
from bt_mission.events.mission_state import MissionState
from bt_mission.views.web.board import Board
from bt_mission.views.web.page_requests import PageRequest


@dataclass(frozen=True)
class OpenPanels:
    """What pages have open, beside what all of them show."""

    map: bool = False
    camera: bool = False


class ShownMission(Protocol):
    """A mission, its board, and what may be done with it."""

    board: Board
    picture: tuple[int, bytes] | None
    """The newest picture of the camera as JPEG, and its number; None without one."""

    @property
    def mission(self) -> MissionState:
        """Its state now."""

    def look(self, panels: OpenPanels) -> None:
        """Take what is new, and put it on the board; without waiting."""

    def perform(self, request: PageRequest) -> None:
        """Do what a page wants of all of it; what came of it is put on the board as a notice."""


class Notices:
    """Lines for all pages; each counts, so that the same one can be said twice."""

    def __init__(self, board: Board) -> None:
        self._board = board
        self._count = 0

    def say(self, text: str) -> None:
        """Say a line."""
        self._count += 1
        self._board.put("notice", [self._count, text])


def put_state(board: Board, mission: MissionState, **more: Any) -> None:
    """Put on the board how the mission stands, and the time."""
    state, tree, charge = mission.state, mission.tree, mission.robot.charge
    board.put(
        "state",
        {
            "mission": tree.mission if tree else state.mission if state else "",
            "status": mission.status,
            "reason": state.reason if state else "",
            "tip": mission.tip,
            "ticks": mission.ticks,
            "goals_sent": mission.goals_sent,
            "breakpoints": mission.breakpoints,
            "charge": None if charge is None else round(charge, 1),
            **more,
        },
    )
    now_ns = mission.now_ns - tree.time_ns if tree else 0
    board.put("clock", {"now": now_ns / NS, "elapsed": mission.elapsed_ns / NS})
