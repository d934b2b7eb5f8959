"""What went wrong in a recorded run, and where: all faults that its evidence shows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from bt_mission.commands.reproduce.diagnosed import DiagnosedFault
from bt_mission.commands.reproduce.evidence import Evidence
from bt_mission.commands.reproduce.motion import motion_faults
from bt_mission.commands.reproduce.sight import (
    Visitor,
    battery_faults,
    fit_of,
    frozen_faults,
    sight_faults,
    visitor_faults,
    visitors,
)
from bt_mission.commands.reproduce.silences import goal_faults, silences
from bt_mission.commands.reproduce.surroundings import StaticSurroundings, surroundings
from bt_mission.robots.model import RobotModel

DECEIVED = ("lidar_frozen", "lidar_dead", "lidar_bias", "lidar_noise", "odometry_dead")
"""Faults during which scans, or the poses to which they belong, are not to be trusted."""
LOST = ("odometry_dead", "drop", "lidar_frozen")
"""Faults during which scans cannot be compared with the world."""
MOST_FAULTS = 40


@dataclass(frozen=True)
class Diagnosis:
    """The faults in the order of their beginning, the world, and the things that came."""

    faults: Sequence[DiagnosedFault]
    around: StaticSurroundings
    things: Sequence[Visitor]


def diagnose(evidence: Evidence, robot: RobotModel) -> Diagnosis:
    """Return what went wrong in a recorded run, and where."""
    faults = [*silences(evidence), *frozen_faults(evidence), *battery_faults(evidence)]
    around = surroundings(evidence, _doubtful(faults, evidence))
    seen = list(sight_faults(evidence, around))
    if seen and around.is_mapped:
        around = surroundings(evidence, _doubtful([*faults, *seen], evidence))
        seen = list(sight_faults(evidence, around))
    lost = [each for each in faults if each.name in LOST]
    faults += [each for each in seen if not any(_overlap(each, other) for other in lost)]
    faults += motion_faults(evidence, robot, faults, fit_of(evidence, around))
    faults += goal_faults(evidence, faults)
    things = visitors(evidence, around, _doubtful(faults, evidence))
    faults += visitor_faults(things)
    faults = [each for each in faults if each.start <= evidence.end_s]
    faults.sort(key=lambda each: each.start)
    return Diagnosis(faults[:MOST_FAULTS], around, things)


def _overlap(a: DiagnosedFault, b: DiagnosedFault) -> bool:
    """Return whether one fault begins while another lasts."""
    return b.start - 0.3 <= a.start <= (math.inf if b.end is None else b.end + 0.3)


def _doubtful(faults: Sequence[DiagnosedFault], evidence: Evidence) -> list[tuple[float, float]]:
    return [
        (each.start, (each.end or evidence.end_s) + 0.2) for each in faults if each.name in DECEIVED
    ]
