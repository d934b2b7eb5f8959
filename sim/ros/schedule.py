"""The schedule: periodic actions on whole steps of the physics, in a fixed order."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from operator import attrgetter

from bt_mission.base.errors import BtMissionError
from sim.physics.names import STEP_NS


class RateError(BtMissionError):
    """A sensor's rate does not fit the steps of the physics."""

    code = "BT-804"


_NEVER = 2**62
"""Nanoseconds: 146 years."""


@dataclass
class _Entry:
    action: Callable[[int], None]
    period_ns: int
    due_ns: int
    index: int = 0


_DUE_NS = attrgetter("due_ns")


class Schedule:
    """Runs actions at their rates. Each gets the number of its run, from 0, as its argument."""

    def __init__(self, start_ns: int) -> None:
        self._start_ns = start_ns
        self._entries: list[_Entry] = []
        self.next_due_ns = start_ns
        """The next instant at which an action is due, ns."""
        self.set_back_ns = 0
        """By how much `/clock` has been set back, ns; schedule and physics never go back."""

    def clock_ns(self, time_ns: int) -> int:
        """Return the time on `/clock` at an instant of the physics, ns."""
        return time_ns - self.set_back_ns

    def set_clock_back(self, time_ns: int) -> None:
        """Restart `/clock` at `time_ns` from its time at the start."""
        self.set_back_ns = time_ns - self._start_ns

    def every(self, rate_hz: float, what: str, action: Callable[[int], None]) -> None:
        """Add an action, first due at the start; after all that were added before it.

        Raises RateError if its period is not a whole number of physics steps.
        """
        period_ns = period_of(rate_hz, what)
        self._entries.append(_Entry(action, period_ns, self._start_ns))

    def once(self, action: Callable[[int], None]) -> None:
        """Add an action that runs once, at the start."""
        self._entries.append(_Entry(action, _NEVER, self._start_ns))

    def restart(self, time_ns: int) -> None:
        """Restart at `time_ns`: periodic actions are due then, and count from 0 again."""
        for entry in self._entries:
            if entry.period_ns != _NEVER:
                entry.index, entry.due_ns = 0, time_ns
        self.next_due_ns = min(map(_DUE_NS, self._entries))

    def run(self, time_ns: int) -> None:
        """Run everything due at `time_ns`, the present due instant."""
        for entry in self._entries:
            if entry.due_ns <= time_ns:
                entry.action(entry.index)
                entry.index += 1
                entry.due_ns += entry.period_ns
        self.next_due_ns = min(map(_DUE_NS, self._entries))


def period_of(rate_hz: float, what: str) -> int:
    """Return a rate's period, ns. Raises RateError where it is no whole number of steps."""
    steps = round(1e9 / rate_hz / STEP_NS)
    if steps < 1 or abs(steps * STEP_NS * rate_hz - 1e9) > 1.0:
        raise RateError(
            f"{what}: expected a rate whose period is a whole number of physics steps of"
            f" {STEP_NS / 1e6:g} ms, got {rate_hz:g} Hz, a period of {1e3 / rate_hz:g} ms;"
            " 5, 10, 20, 40, 50 and 100 Hz fit"
        )
    return steps * STEP_NS
