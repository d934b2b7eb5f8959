"""What is a matter of choice in mapping and in exploring a map, as ROS parameters."""

from __future__ import annotations

from dataclasses import dataclass

from action_servers.core.parameters import number


@dataclass(frozen=True, slots=True, kw_only=True)
class FrontierTuning:
    """Of explore_frontiers: the servers' parameters `frontiers.*`."""

    min_length: float = number(
        0.4,
        0.05,
        100.0,
        "Length of the shortest frontier worth a visit where a goal says 0, m: a Waffle passes "
        "where 0.5 m is free, and a cell on either side is the seam of the wall.",
    )
    map_wait: float = number(
        5.0,
        0.5,
        600.0,
        "How long it waits for a map, and for the robot's place on it, before it gives up, s.",
    )
    settle: float = number(
        2.5,
        0.5,
        60.0,
        "How long it stands and looks before it believes what the map says of frontiers, s: the "
        "map comes once a second, and a cell is free when two scans say so.",
    )


FRONTIERS = FrontierTuning()
"""The defaults."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MapperTuning:
    """Of the mapper: its own parameters."""

    update_period: float = number(
        0.2,
        0.05,
        2.0,
        "How often a scan is added, s: every scan of an LDS-01, every other one of a Waffle in "
        "simulation.",
        is_fixed=True,
    )
    updates_per_map: int = number(
        5, 1, 100, "Updates from one map to the next; with the default period, one a second."
    )
