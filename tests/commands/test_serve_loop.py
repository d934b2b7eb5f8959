"""The loop of `bt-mission serve`, without a graph."""

from __future__ import annotations

from typing import Any

import pytest

from bt_mission.base.interrupts import InterruptSignals
from bt_mission.commands.serve import _serve_missions


class Served:
    """A graph and its server; each step counts, and the steps of these numbers raise."""

    executive = mission_node = None

    def __init__(self, *broken: int) -> None:
        self.steps = 0
        self.events: list[str] = []
        self.is_busy = True
        self._broken = broken
        self._ends_at = 0

    def step(self, *_: Any) -> None:
        self.steps += 1
        if self.steps in self._broken:
            raise ValueError(f"step {self.steps}")
        if self.steps == self._ends_at:
            self.is_busy = False

    def look(self) -> None:
        pass

    def close(self, reason: str) -> None:
        self.events.append(reason.partition(" (")[0])
        self._ends_at = self.steps + 3

    def abandon(self, reason: str) -> None:
        self.events.append(f"abandoned: {reason.partition(' (')[0]}")

    def serve(self, interrupts: InterruptSignals) -> bool:
        return _serve_missions(self, self, interrupts)  # type: ignore[arg-type]


def test_an_exception_ends_the_mission_before_the_server() -> None:
    """Its goals are seen to their end, and the command fails with the cause."""
    served = Served(5)
    with pytest.raises(ValueError, match="step 5"):
        served.serve(InterruptSignals())
    assert served.events == ["a callback failed: ValueError: step 5"]
    assert served.steps == 8


def test_a_second_exception_leaves_at_once() -> None:
    """Nobody knows whether the goals would ever end."""
    served = Served(5, 6)
    with pytest.raises(ValueError, match="step 6"):
        served.serve(InterruptSignals())
    assert served.events[1] == "abandoned: a callback failed: ValueError: step 6"


def test_a_signal_ends_it_in_good_order() -> None:
    """The first waits for the goals; the second does not."""
    served, interrupts = Served(), InterruptSignals()
    interrupts.note("Ctrl-C")
    served._ends_at = 3
    served.is_busy = False
    assert served.serve(interrupts)
    served.is_busy = True
    interrupts.note("Ctrl-C")
    assert not served.serve(interrupts)
    assert served.events == ["abandoned: ended at once by a second Ctrl-C"]
