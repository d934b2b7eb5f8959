"""What the encoders of the wheels count: the wheels' turning, and what they spin in vain."""

from __future__ import annotations

from sim.sensors.noise import Noise


class Encoders:
    """Angles of both wheels since the start, rad.

    `slip` is the mean share of a wheel's turning that moves nothing. How much it is between two
    readings varies by half of it (1 sigma), by itself for each wheel, and is never negative.
    """

    def __init__(self, slip: float, seed: int, prefix: str = "") -> None:
        self._slip = slip
        self._noise = Noise(seed, f"{prefix}encoders", 2)
        self.start(0.0, 0.0)

    def start(self, left: float, right: float) -> None:
        """Count from these angles on, as at the first time."""
        self._index = 0
        self._start = self._last = (left, right)
        self._in_vain = (0.0, 0.0)

    def read(self, left: float, right: float) -> float:
        """Take the true angles; returns how far both wheels have turned together, rad."""
        turned = left - self._last[0], right - self._last[1]
        self._last = left, right
        if self._slip:
            shares = self._slip * (1 + self._noise.at(self._index) / 2).clip(min=0.0)
            self._in_vain = (
                self._in_vain[0] + turned[0] * float(shares[0]),
                self._in_vain[1] + turned[1] * float(shares[1]),
            )
            self._index += 1
        return abs(turned[0]) + abs(turned[1])

    def angles(self, left: float, right: float) -> tuple[float, float]:
        """Return what the encoders show where the wheels truly stand so."""
        return (
            left - self._start[0] + self._in_vain[0],
            right - self._start[1] + self._in_vain[1],
        )
