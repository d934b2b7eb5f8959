"""The summary of a run: one object for programs, one paragraph for people."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bt_mission.executive.executive import Executive
    from bt_mission.executive.leaf_statistics import LeafSummary
    from bt_mission.executive.trace import Trace
    from bt_mission.language.mission import Mission


@dataclass(frozen=True)
class Report:
    """What a run came to; `str()` of it is a summary for people.

    Fields that only a simulation knows are None when attached.

    Attributes:
        virtual_s: ROS time from start to end, s.
        wall_s: Wall time of the same, s.
        real_time_factor: Virtual seconds per wall second.
        goals_left_behind: Goals whose end no server confirmed.
        distance_travelled_m: True path length of the robot, m.
        trace_sha256: Equal for two runs in which the same things happened at the same times.
        leaves: What each leaf came to, where they were counted.
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

    def __str__(self) -> str:
        return self.as_text()

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
        facts = [f"{self.goals_sent} goals sent", f"{self.goals_left_behind} orphaned"]
        if self.distance_travelled_m is not None:
            facts.append(f"{self.distance_travelled_m:.2f} m driven")
        if self.collisions is not None:
            facts.append(f"{self.collisions} collisions")
        lines.append("  " + ", ".join(facts))
        return "\n".join(lines)


def report_on(
    mission: Mission, executive: Executive, trace: Trace, virtual_s: float, wall_s: float
) -> Report:
    """The report of a mission that has ended, as far as its executive knows."""
    return Report(
        mission=mission.name,
        status=str(executive.status),
        reason=executive.reason,
        world=mission.world,
        robot=mission.robot,
        seed=mission.seed,
        virtual_s=round(virtual_s, 6),
        wall_s=round(wall_s, 3),
        real_time_factor=round(virtual_s / wall_s, 1) if wall_s > 0 else 0.0,
        ticks=executive.ticks,
        goals_sent=executive.goals_sent,
        goals_left_behind=len(executive.goals_left_behind),
        collisions=None,
        distance_travelled_m=None,
        trace_sha256=trace.sha256,
    )
