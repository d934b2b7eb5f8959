"""The summary of a run: one object for programs, one paragraph for people."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bt_mission.executive.leaf_statistics import LeafSummary


@dataclass(frozen=True)
class Report:
    """What a run came to. Fields that only a simulation knows are None when attached.

    :param virtual_s: ROS time from start to end, s; wall_s: wall time of the same, s.
    :param real_time_factor: virtual seconds per wall second.
    :param goals_left_behind: goals whose end no server confirmed.
    :param distance_travelled_m: true path length of the robot, m.
    :param trace_sha256: equal for two runs in which the same things happened at the same times.
    :param leaves: what each leaf came to, where they were counted.
    """

    mission: str
    status: str
    reason: str
    world: str | None
    robot: str
    seed: int
    virtual_s: float
    wall_s: float
    real_time_factor: float
    ticks: int
    goals_sent: int
    goals_left_behind: int
    collisions: int | None
    distance_travelled_m: float | None
    trace_sha256: str
    leaves: tuple[LeafSummary, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """The fields by name, ready for JSON."""
        return asdict(self)

    def as_text(self) -> str:
        """Two or three lines for people."""
        lines = [f"{self.mission}: {self.status}" + (f": {self.reason}" if self.reason else "")]
        lines.append(
            f"  {self.virtual_s:.2f} s in {self.wall_s:.2f} s of wall time "
            f"({self.real_time_factor:.1f} x real time), seed {self.seed}"
        )
        facts = [f"{self.goals_sent} goals sent", f"{self.goals_left_behind} left behind"]
        if self.distance_travelled_m is not None:
            facts.append(f"{self.distance_travelled_m:.2f} m driven")
        if self.collisions is not None:
            facts.append(f"{self.collisions} collisions")
        lines.append("  " + ", ".join(facts))
        return "\n".join(lines)
