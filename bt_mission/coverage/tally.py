"""What runs have reached, added up by place in the mission file.

A file of which several missions, tests, seeds or processes know something is one record. It is
plain data (:meth:`Tally.data`), to be sent from one process to another, and written as JSON.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

VERSION = 1

Key = tuple[int, int, str]
"""Line, column and kind. In XML one element can stand for two nodes, of different kinds."""


@dataclass
class Spot:
    """A node of a mission, where it stands.

    Args:
        tree: The named tree that it belongs to; empty is the mission's own.
        runs: In how many runs it was reached.
        outcomes: What can come of it, and in how many runs it did.
        branches: The ways that it can choose, and in how many runs it did.
    """

    line: int
    column: int
    kind: str
    name: str
    tree: str = ""
    depth: int = 0
    runs: int = 0
    outcomes: dict[str, int] = field(default_factory=dict)
    branches: dict[str, int] = field(default_factory=dict)

    @property
    def key(self) -> Key:
        """Tells it from others of its file."""
        return self.line, self.column, self.kind

    @property
    def missing(self) -> list[str]:
        """What could have come of it, and the ways that it could have gone, but never did."""
        return [
            one for part in (self.outcomes, self.branches) for one, runs in part.items() if not runs
        ]

    def add(self, other: Spot) -> None:
        """Add what somebody else has seen here."""
        self.runs += other.runs
        for ours, theirs in ((self.outcomes, other.outcomes), (self.branches, other.branches)):
            for name, runs in theirs.items():
                ours[name] = ours.get(name, 0) + runs


@dataclass(frozen=True)
class Score:
    """How much of what there is was reached."""

    nodes: int = 0
    reached: int = 0
    outcomes: int = 0
    seen: int = 0
    branches: int = 0
    taken: int = 0

    @property
    def percent(self) -> float:
        """Of nodes, outcomes and branches together; of nothing, all is reached."""
        there = self.nodes + self.outcomes + self.branches
        return 100 * (self.reached + self.seen + self.taken) / there if there else 100.0

    @classmethod
    def of(cls, spots: Iterable[Spot]) -> Score:
        """Count what was reached of some nodes."""
        known = list(spots)
        outcomes = [runs for spot in known for runs in spot.outcomes.values()]
        branches = [runs for spot in known for runs in spot.branches.values()]
        return cls(
            nodes=len(known),
            reached=sum(spot.runs > 0 for spot in known),
            outcomes=len(outcomes),
            seen=sum(runs > 0 for runs in outcomes),
            branches=len(branches),
            taken=sum(runs > 0 for runs in branches),
        )


@dataclass
class Covered:
    """One file of missions.

    Args:
        label: What the file is called.
        missions: Names of the missions that used it.
        source: Its lines.
    """

    label: str
    missions: set[str] = field(default_factory=set)
    source: tuple[str, ...] = ()
    spots: dict[Key, Spot] = field(default_factory=dict)

    def in_order(self) -> list[Spot]:
        """Its nodes in the order of the file."""
        return sorted(self.spots.values(), key=lambda spot: (spot.line, spot.column, spot.depth))

    @property
    def score(self) -> Score:
        """How much of it was reached."""
        return Score.of(self.spots.values())

    def add(self, other: Covered) -> None:
        """Add what somebody else knows of this file."""
        self.missions |= other.missions
        self.source = self.source or other.source
        for key, spot in other.spots.items():
            if key in self.spots:
                self.spots[key].add(spot)
            else:
                self.spots[key] = spot


@dataclass
class Tally:
    """All files of missions, by a key that is the same in every process."""

    files: dict[str, Covered] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(self.files)

    def in_order(self) -> Iterator[Covered]:
        """The files by their names; texts that share a name are numbered."""
        labels = [covered.label for covered in self.files.values()]
        for label in sorted(set(labels)):
            same = [self.files[key] for key in sorted(self.files) if self.files[key].label == label]
            for number, covered in enumerate(same, 1):
                name = label if len(same) == 1 else f"{label} ({number})"
                yield replace(covered, label=name)

    @property
    def score(self) -> Score:
        """How much of all was reached."""
        return Score.of(spot for one in self.files.values() for spot in one.spots.values())

    def add(self, key: str, covered: Covered) -> None:
        """Add what is known of a file."""
        if key in self.files:
            self.files[key].add(covered)
        else:
            self.files[key] = covered

    def data(self) -> dict[str, Any]:
        """As plain data, to be sent."""
        return {
            key: {
                "label": one.label,
                "missions": sorted(one.missions),
                "source": list(one.source),
                "spots": [vars(spot) for spot in one.in_order()],
            }
            for key, one in self.files.items()
        }

    def take(self, data: Mapping[str, Any]) -> None:
        """Add what another process has sent."""
        for key, one in data.items():
            spots = [Spot(**spot) for spot in one["spots"]]
            covered = Covered(
                one["label"],
                set(one["missions"]),
                tuple(one["source"]),
                {spot.key: spot for spot in spots},
            )
            self.add(key, covered)

    def report(self) -> dict[str, Any]:
        """For programs: a score in all and of each file, and each node with what was seen of it."""
        return {
            "version": VERSION,
            "total": _told(self.score),
            "files": {
                one.label: {
                    "missions": sorted(one.missions),
                    "score": _told(one.score),
                    "nodes": [vars(spot) for spot in one.in_order()],
                }
                for one in self.in_order()
            },
        }


def _told(score: Score) -> dict[str, float]:
    return vars(score) | {"percent": round(score.percent, 2)}
