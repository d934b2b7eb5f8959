"""The summary of a fleet's run: one object for programs, some lines for people."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rich.cells import cell_len

from bt_mission.base.text import counted, escape_control, seconds
from bt_mission.base.verdicts import conclusion
from bt_mission.executive.events.log import verdict
from bt_mission.executive.report import Report
from bt_mission.executive.status import MissionStatus


@dataclass(frozen=True)
class RobotReport:
    """The outcome of a run for one robot.

    Attributes:
        mission: The report of its mission; its collisions are those with anything.
        collisions_with: How many of them were with each other robot, by its name.
    """

    robot: str
    mission: Report
    collisions_with: Mapping[str, int]

    @property
    def collisions_with_world(self) -> int:
        """Those that were not with another robot."""
        return (self.mission.collisions or 0) - sum(self.collisions_with.values())

    def as_dict(self) -> dict[str, Any]:
        """The fields by name, ready for JSON."""
        return {
            "name": self.robot,
            **self.mission.as_dict(),
            "collisions_with_world": self.collisions_with_world,
            "collisions_with_robots": dict(self.collisions_with),
        }


@dataclass(frozen=True)
class FleetReport:
    """The outcome of a fleet's run; `str()` of it is a summary for people.

    Attributes:
        seed: Of all sensor noise.
        virtual_s: ROS time from the start to the end of the last mission, s.
        wall_s: Wall time of the same, s.
    """

    fleet: str
    world: str
    seed: int
    virtual_s: float
    wall_s: float
    robots: tuple[RobotReport, ...]

    @property
    def status(self) -> str:
        """``success`` if every mission has succeeded; ``interrupted`` if one was interrupted."""
        ends = [robot.mission.status for robot in self.robots]
        worst = (MissionStatus.INTERRUPTED, MissionStatus.FAILURE)
        return next((str(status) for status in worst if status in ends), str(MissionStatus.SUCCESS))

    @property
    def verdict(self) -> str:
        """The status, or if every mission has succeeded, the worst verdict of a robot."""
        results = [each for robot in self.robots for each in robot.mission.requirements]
        untested = [line for robot in self.robots for line in robot.mission.untested]
        return conclusion(self.status, "", results, untested)[0]

    @property
    def passed(self) -> bool:
        """Has every mission succeeded, and does no requirement fail?"""
        return self.verdict == "success"

    @property
    def collisions_with_world(self) -> int:
        """How often a robot has touched something that is neither the floor nor a robot."""
        return sum(robot.collisions_with_world for robot in self.robots)

    @property
    def collisions_among_robots(self) -> int:
        """How often two robots have touched each other; each time counts once."""
        counts: dict[frozenset[str], int] = {}
        for robot in self.robots:
            for other, count in robot.collisions_with.items():
                pair = frozenset((robot.robot, other))
                counts[pair] = max(count, counts.get(pair, 0))
        return sum(counts.values())

    @property
    def real_time_factor(self) -> float:
        """Virtual seconds per wall second."""
        return round(self.virtual_s / self.wall_s, 1) if self.wall_s > 0 else 0.0

    @property
    def missions(self) -> Mapping[str, Report]:
        """The report of each mission, by the name of its robot."""
        return {robot.robot: robot.mission for robot in self.robots}

    def as_dict(self) -> dict[str, Any]:
        """The fields by name, ready for JSON; `robots` has an object for each robot."""
        return {
            "fleet": self.fleet,
            "verdict": self.verdict,
            "status": self.status,
            "succeeded": self._succeeded,
            "world": self.world,
            "seed": self.seed,
            "virtual_s": self.virtual_s,
            "wall_s": self.wall_s,
            "real_time_factor": self.real_time_factor,
            "collisions_with_world": self.collisions_with_world,
            "collisions_among_robots": self.collisions_among_robots,
            "robots": [robot.as_dict() for robot in self.robots],
        }

    def __str__(self) -> str:
        return self.as_text()

    def as_text(self) -> str:
        """A few lines for people: of each robot, and of all."""
        missions = counted(len(self.robots), "mission")
        lines = [
            f"{self.fleet}: {self.verdict} ({self._succeeded} of {missions} succeeded)",
            *self._rows(),
        ]
        reports = [robot.mission for robot in self.robots]
        distance_m = sum(report.distance_travelled_m or 0.0 for report in reports)
        time = f"{seconds(self.virtual_s)} in {seconds(self.wall_s)} of wall time"
        goals = sum(report.goals_sent for report in reports)
        orphaned = sum(report.goals_left_behind for report in reports)
        among = self.collisions_among_robots
        factor = f"{self.real_time_factor:.1f} x real time"
        lines += [
            f"  {time} ({factor}), world {self.world}, seed {self.seed}",
            f"  {counted(goals, 'goal')} sent, {orphaned} orphaned, {distance_m:.2f} m driven",
            f"  collisions: {self.collisions_with_world} with the world, {among} among robots",
        ]
        return "\n".join(map(escape_control, lines))

    @property
    def _succeeded(self) -> int:
        return sum(robot.mission.status == MissionStatus.SUCCESS for robot in self.robots)

    def _rows(self) -> list[str]:
        """Give a line for each robot, and below it what did not go well."""
        table = [_row(robot) for robot in self.robots]
        widths = [max(cell_len(row[at]) for row in table) for at in range(len(table[0]))]
        lines = []
        for robot, (name, mission, *figures, verdict_) in zip(self.robots, table, strict=True):
            line = f"  {_left(name, widths[0])}  {_left(mission, widths[1])}"
            for figure, width in zip(figures, widths[2:-1], strict=True):
                line += f"  {' ' * (width - cell_len(figure))}{figure}"
            lines.append(f"{line}  {verdict_}")
            lines += [
                f"    requirement {each}"
                for each in robot.mission.requirements
                if each.fails or each.verdict == "unknown"
            ]
            lines += [f"    fault {each}" for each in robot.mission.faults]
        return lines


def _left(text: str, width: int) -> str:
    return text + " " * (width - cell_len(text))


def _row(robot: RobotReport) -> list[str]:
    report = robot.mission
    return [
        robot.robot,
        report.mission,
        seconds(report.virtual_s),
        f"{report.distance_travelled_m or 0.0:.2f} m",
        counted(report.collisions or 0, "collision"),
        verdict(*report.conclusion),
    ]
