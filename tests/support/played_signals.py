"""Signals of requirements whose values a test sets."""

from __future__ import annotations

from collections.abc import Mapping

from bt_mission.requirements.compiler import Number, Reader
from bt_mission.requirements.language.syntax import SignalValue

Played = float | bool | str | None


class PlayedSignals:
    """Signals by their texts; others are unknown.

    Attributes:
        values: At the present instant.
        bounds: Lower bounds of signals that have a cheap one, at the present instant.
        reads: How often a value was read.
    """

    def __init__(self, values: Mapping[str, Played], **bounds: float) -> None:
        self.values, self.bounds = values, bounds
        self.reads = 0

    def reader(self, signal: SignalValue) -> Reader | str:
        """Return what reads a signal."""
        if signal.key not in self.values:
            return "only a simulation provides it"

        def read() -> Played:
            self.reads += 1
            return self.values[signal.key]

        return read

    def lower_bound(self, signal: SignalValue) -> Number | None:
        """Return what gives a bound of a signal, if it has one."""
        return (lambda: self.bounds[signal.key]) if signal.key in self.bounds else None

    def measured_by(self, _signal: SignalValue) -> str:
        """Return that every value is the truth."""
        return ""
