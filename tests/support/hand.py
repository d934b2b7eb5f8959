"""A person's hand in a graph on the virtual clock."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bt_mission.base.interrupts import InterruptSignals
from bt_mission.ros.virtual_time.discovery import pause
from tests.support.graph import Graph


class VirtualHand:
    """Steps a graph; what a test does meanwhile are moves.

    Its attribute ``pauses`` is how many milliseconds of wall time the middleware's threads are
    left at each step, for what is latched.
    """

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.node = graph.node("_bt_mission_hand_1")
        self.interrupts = InterruptSignals()
        self.pauses = 0
        self._moves: list[tuple[Callable[[], Any], Callable[[], Any]]] = []

    def when(self, condition: Callable[[], Any], move: Callable[[], Any]) -> None:
        """Make a move once a condition holds, after all moves before it."""
        self._moves.append((condition, move))

    def at(self, seconds: float, move: Callable[[], Any]) -> None:
        """Make a move at a virtual time."""
        self.when(lambda: self.graph.now_s >= seconds - 1e-9, move)

    def press_ctrl_c(self) -> None:
        self.interrupts.note("Ctrl-C")

    @property
    def now_ns(self) -> int:
        return self.graph.clock.now_ns

    def step(self) -> None:
        while self._moves and self._moves[0][0]():
            self._moves.pop(0)[1]()
        for _ in range(self.pauses):
            pause(self.graph.context)
        self.graph.step()

    def glance(self) -> None:
        """The same, where time moves only by steps."""
        self.step()

    def follow_clock(self) -> None:
        """The node's clock is the virtual one already."""
