"""How fast virtual time runs against the wall. Pure: whoever paces reads the clock."""

from __future__ import annotations

from dataclasses import dataclass, field

from bt_mission.core.errors import BtMissionError

SLOWEST, FASTEST = 0.01, 1000.0

MOST_LAG_NS = 500_000_000
"""Time, ns, that is caught up with, of the wall or of the world, whichever is less; what lies
further back is given up. Whoever drives the robot hears nothing while the world makes up for it."""

WINDOW_NS = 10_000_000_000
"""Wall time, ns, over which the speed that is reached is measured."""


class SpeedError(BtMissionError):
    """A speed at which nothing useful can be paced."""


def check_speed(speed: float) -> None:
    """Raise SpeedError for a speed that is not between SLOWEST and FASTEST."""
    if not SLOWEST <= speed <= FASTEST:
        raise SpeedError(f"expected a speed from {SLOWEST} to {FASTEST:g}, got {speed}")


@dataclass
class SpeedPacer:
    """Maps wall time to virtual time at a speed (1 is real time), from one instant of both on."""

    speed: float
    wall_ns: int
    time_ns: int
    _window_start_ns: int = field(init=False)
    _lost_ns: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        self._window_start_ns = self.wall_ns

    def target(self, wall_ns: int, time_ns: int) -> int:
        """Return the virtual time that is due at `wall_ns`, where it now is `time_ns`."""
        target = self.time_ns + round((wall_ns - self.wall_ns) * self.speed)
        most_ns = round(MOST_LAG_NS * min(self.speed, 1.0))
        lag_ns = target - time_ns
        if lag_ns > most_ns:
            self._lost_ns += round((lag_ns - most_ns) / self.speed)
            target = time_ns + most_ns
            self.wall_ns, self.time_ns = wall_ns, target
        return max(target, time_ns)

    def set_speed(self, speed: float, wall_ns: int, time_ns: int) -> None:
        """Go on at another speed from here."""
        self.speed, self.wall_ns, self.time_ns = speed, wall_ns, time_ns
        self._window_start_ns, self._lost_ns = wall_ns, 0

    def shortfall(self, wall_ns: int) -> float | None:
        """Return the speed reached, once a window, where it is less than 0.9 of the one asked."""
        window_ns = wall_ns - self._window_start_ns
        if window_ns < WINDOW_NS:
            return None
        reached = 1 - self._lost_ns / window_ns
        self._window_start_ns, self._lost_ns = wall_ns, 0
        return self.speed * reached if reached < 0.9 else None
