"""When a goal tells something: at whole seconds from its first control step, or when it changes."""

from __future__ import annotations

import math

from action_servers.core.maneuver import Fields

ROUNDING_S = 1e-6


class Ticker:
    """Says once for every second that it has passed.

    Times are seconds as floats, so a second counts as full a microsecond early.
    """

    def __init__(self) -> None:
        self._start_s: float | None = None
        self._told = 0
        self.elapsed_s = 0.0
        """Seconds since the first update."""

    @property
    def count(self) -> int:
        """How many seconds are full."""
        return int(self.elapsed_s + ROUNDING_S)

    def update(self, time_s: float) -> None:
        """Take in the time of a control step."""
        if self._start_s is None:
            self._start_s = time_s
        self.elapsed_s = max(self.elapsed_s, time_s - self._start_s)

    def has_reached(self, duration_s: float) -> bool:
        """Return whether so many seconds have passed."""
        return self._start_s is not None and self.elapsed_s >= duration_s - ROUNDING_S

    def take(self) -> bool:
        """Return whether a second has become full since the last call."""
        told, self._told = self._told, self.count
        return self._told > told


class News:
    """Feedback that is told when it has changed, and after `again_s` seconds even if it has not."""

    def __init__(self, again_s: float = math.inf) -> None:
        self._again_s = again_s
        self._told: tuple[Fields, float] | None = None

    def of(self, fields: Fields, time_s: float = 0.0) -> Fields | None:
        """Return the fields when they are to be told now, else None."""
        if self._told is not None:
            told, told_s = self._told
            if told == fields and time_s - told_s < self._again_s - ROUNDING_S:
                return None
        self._told = fields, time_s
        return fields
