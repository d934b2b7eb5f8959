"""What people see while a sweep runs, as lines of text."""

from __future__ import annotations

from dataclasses import dataclass, field

from bt_mission.core.text import escape_control
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.sweeps.row import ScenarioRow
from bt_mission.sweeps.summary import SweepTally

MOST_REASONS = 4
NO_WORKERS = "no worker is left: it waits for others; Ctrl-C ends it, and --resume goes on"


@dataclass
class SweepProgress:
    """How far a sweep is.

    Attributes:
        name: Of the mission.
        total: Scenarios of the whole sweep.
        tally: What the rows come to, those of before `--resume` included.
        here: Rows of this start.
        to_record: How many of the worst are recorded when all have ended.
        recorded: How many of them are.
    """

    name: str
    total: int
    tally: SweepTally = field(default_factory=SweepTally)
    here: int = 0
    to_record: int = 0
    recorded: int = 0
    _wall: Stopwatch | None = field(default=None, init=False)

    def add(self, row: ScenarioRow) -> None:
        """Count a row that has come."""
        self.tally.add(row)
        self.here += 1

    def start(self) -> None:
        """The workers are ready: from here on the rate counts."""
        self._wall = Stopwatch()

    @property
    def rate(self) -> float:
        """Scenarios per second of wall time since the start; 0 before the first."""
        elapsed_s = self._wall.elapsed_s if self._wall else 0.0
        return self.here / elapsed_s if elapsed_s > 0 else 0.0

    def lines(self, workers: int) -> list[str]:
        """A line with the state, and one for each of the most frequent reasons of failures."""
        count = self.tally.count
        parts = [f"{self.name}: {count.scenarios:,} of {self.total:,}"]
        if self.here:
            left = self.total - count.scenarios
            parts += [f"{self.rate:.3g}/s", f"{duration(left / self.rate)} left"]
        if self.to_record:
            parts.append(f"{self.recorded} of the worst {self.to_record} recorded")
        parts.append(f"{workers} worker{'s' * (workers != 1)}" if workers else NO_WORKERS)
        lines = ["   ".join(parts)]
        if count.scenarios:
            lines.append(f"  {count}")
        failures = self.tally.failures
        lines += [f"  {one.count:,} x {one.reason}" for one in failures[:MOST_REASONS]]
        if len(failures) > MOST_REASONS:
            rest = sum(one.count for one in failures[MOST_REASONS:])
            lines.append(f"  {rest:,} x for {len(failures) - MOST_REASONS} other reasons")
        return [escape_control(one) for one in lines]


def duration(seconds: float) -> str:
    """Seconds for people: ``42 s``, ``3 min``, ``2 h 10 min``."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    if minutes < 100:
        return f"{minutes} min"
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours < 48 else f"{hours / 24:.1f} days"
