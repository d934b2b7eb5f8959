"""When a goal sends feedback: at whole seconds from its first control step, or on a change."""

from __future__ import annotations

import math

from action_servers.core.maneuver import Fields

ROUNDING_S = 1e-6


class Ticker:
    """Reports each full second once.

    Times are seconds as floats, so a second counts as full a microsecond early.
    """

    def __init__(self) -> None:
        self._start_s: float | None = None
        self._taken = 0
        self.elapsed_s = 0.0
        """Seconds since the first update."""

    @property
    def count(self) -> int:
        """The number of full seconds."""
        return int(self.elapsed_s + ROUNDING_S)

    def update(self, time_s: float) -> None:
        """Note the time of a control step, s."""
        if self._start_s is None:
            self._start_s = time_s
        self.elapsed_s = max(self.elapsed_s, time_s - self._start_s)

    def has_reached(self, duration_s: float) -> bool:
        """Return whether `duration_s` seconds have passed."""
        return self._start_s is not None and self.elapsed_s >= duration_s - ROUNDING_S

    def take(self) -> bool:
        """Return whether a second has become full since the last call."""
        before, self._taken = self._taken, self.count
        return self._taken > before


class ChangedFields:
    """Feedback that is sent when it has changed, and again after `again_s` seconds."""

    def __init__(self, again_s: float = math.inf) -> None:
        self._again_s = again_s
        self._sent: tuple[Fields, float] | None = None

    def of(self, fields: Fields, time_s: float = 0.0) -> Fields | None:
        """Return the fields if they are to be sent now, else None."""
        if self._sent is not None:
            sent, sent_s = self._sent
            if sent == fields and time_s - sent_s < self._again_s - ROUNDING_S:
                return None
        self._sent = fields, time_s
        return fields
