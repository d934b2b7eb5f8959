"""The coverage that runs reach: of a mission as a bitmap, of files as counts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Self

from bt_mission.executive.executive import Executive
from bt_mission.language.mission import Mission
from bt_mission.scenarios.coverage.places import CoveragePlace, places
from bt_mission.scenarios.coverage.watch import CoverageWatch

VERSION = 1


class CoverageRecord:
    """The places of a mission that one or several runs have reached.

    Each mark of a place has a name: ``0.1 drive: reached``, ``0.1 drive: outcome canceled by
    condition``, ``half:0.2 way out: branch 2 turn``. Names differ, and their order is that of
    `places`.

    Args:
        places: The places of the mission, with the runs so far.
    """

    def __init__(self, places: Iterable[CoveragePlace]) -> None:
        self.places = tuple(places)
        self._marks = [(place.marks, mark) for place in self.places for mark in place.marks]
        self.names = tuple(
            f"{place.label}: {mark}" for place in self.places for mark in place.marks
        )

    @classmethod
    def of(cls, mission: Mission) -> Self:
        """Return the record of a mission in which nothing is reached."""
        return cls(place for _, _, place in places(mission))

    @classmethod
    def attach(cls, mission: Mission, executive: Executive) -> Self:
        """Record what a run reaches from now on. Call it before the first tick."""
        by_step = {id(step): place for _, step, place in places(mission)}
        CoverageWatch(mission, executive, by_step)
        return cls(by_step.values())

    def add(self, text: str, runs: int = 1) -> tuple[str, ...]:
        """Add runs that reached the same places. Return the names of marks that are reached first.

        Args:
            text: What each run reached, as `as_hex` writes it.

        Raises:
            ValueError: The text is not that of a record with the same number of marks.
        """
        bits = int(text, 16) if text else 0
        if len(text) != self._digits or bits >> len(self._marks):
            raise ValueError(f"expected {self._digits} hexadecimal digits, got {text!r}")
        first = []
        for number, (marks, mark) in enumerate(self._marks):
            if bits >> number & 1:
                if not marks[mark]:
                    first.append(self.names[number])
                marks[mark] += runs
        return tuple(first)

    def as_hex(self) -> str:
        """The record in hexadecimal: four marks in each digit, the first mark in the last digit."""
        bits = sum(1 << number for number, (marks, mark) in enumerate(self._marks) if marks[mark])
        return f"{bits:0{self._digits}x}" if self._digits else ""

    @property
    def _digits(self) -> int:
        return -(-len(self._marks) // 4)

    @property
    def reached(self) -> tuple[str, ...]:
        """The names of what was reached, in their order."""
        return self._named(is_reached=True)

    @property
    def missing(self) -> tuple[str, ...]:
        """The names of what was not."""
        return self._named(is_reached=False)

    def _named(self, *, is_reached: bool) -> tuple[str, ...]:
        pairs = zip(self.names, self._marks, strict=True)
        return tuple(name for name, (marks, mark) in pairs if bool(marks[mark]) is is_reached)


@dataclass(frozen=True)
class Score:
    """How many of the places are reached."""

    nodes: int = 0
    reached: int = 0
    outcomes: int = 0
    seen: int = 0
    branches: int = 0
    taken: int = 0

    @property
    def percent(self) -> float:
        """The percentage of nodes, outcomes and branches together; 100 without any."""
        there = self.nodes + self.outcomes + self.branches
        return 100 * (self.reached + self.seen + self.taken) / there if there else 100.0

    @classmethod
    def of(cls, places: Iterable[CoveragePlace]) -> Score:
        """Count what was reached of some places."""
        known = list(places)
        parts = (
            [place.runs for place in known],
            [runs for place in known for runs in place.outcomes.values()],
            [runs for place in known for runs in place.branches.values()],
        )
        return cls(*(count for runs in parts for count in (len(runs), sum(map(bool, runs)))))

    def as_dict(self) -> dict[str, float]:
        """Return the score as JSON data."""
        return {**vars(self), "percent": round(self.percent, 2)}


@dataclass
class CoveredFile:
    """The coverage of a file of missions, collected over missions, tests and processes.

    Attributes:
        label: The name of the file.
        missions: Names of the missions that used it.
        source: The lines of the file.
        places: Its nodes by their keys.
    """

    label: str
    missions: set[str] = field(default_factory=set)
    source: tuple[str, ...] = ()
    places: dict[tuple[int, int, str], CoveragePlace] = field(default_factory=dict)

    def in_order(self) -> list[CoveragePlace]:
        """Its nodes in the order of the file."""
        return sorted(
            self.places.values(), key=lambda place: (place.line, place.column, place.depth)
        )

    @property
    def score(self) -> Score:
        """How many of its places are reached."""
        return Score.of(self.places.values())

    def add(self, other: CoveredFile) -> None:
        """Add the coverage of the same file from another mission, test or process."""
        self.missions |= other.missions
        self.source = self.source or other.source
        for key, place in other.places.items():
            known = self.places.setdefault(key, place)
            if known is not place:
                for mark, runs in place.marks.items():
                    known.marks[mark] = known.marks.get(mark, 0) + runs


@dataclass
class CoverageTally:
    """All files of missions, by a key that is the same in every process."""

    files: dict[str, CoveredFile] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(self.files)

    def in_order(self) -> Iterator[CoveredFile]:
        """The files by name. Texts that share a name are numbered."""
        labels = [covered.label for covered in self.files.values()]
        for label in sorted(set(labels)):
            same = [self.files[key] for key in sorted(self.files) if self.files[key].label == label]
            for number, covered in enumerate(same, 1):
                name = label if len(same) == 1 else f"{label} ({number})"
                yield replace(covered, label=name)

    @property
    def score(self) -> Score:
        """The score of all files together."""
        return Score.of(
            place for covered in self.files.values() for place in covered.places.values()
        )

    def add(self, key: str, covered: CoveredFile) -> None:
        """Add what is known of a file."""
        if self.files.setdefault(key, covered) is not covered:
            self.files[key].add(covered)

    def data(self) -> dict[str, Any]:
        """Return plain data, to be sent to another process."""
        return {
            key: {
                "label": covered.label,
                "missions": sorted(covered.missions),
                "source": list(covered.source),
                "places": [asdict(place) for place in covered.in_order()],
            }
            for key, covered in self.files.items()
        }

    def take(self, data: Mapping[str, Any]) -> None:
        """Add what another process has sent."""
        for key, entry in data.items():
            places = [CoveragePlace(**place) for place in entry["places"]]
            source, by_key = tuple(entry["source"]), {place.key: place for place in places}
            self.add(key, CoveredFile(entry["label"], set(entry["missions"]), source, by_key))

    def report(self) -> dict[str, Any]:
        """Return the JSON report: scores in total and of each file, and counts of each node."""
        names = ("line", "column", "kind", "name", "tree", "depth", "runs", "outcomes", "branches")
        return {
            "version": VERSION,
            "total": self.score.as_dict(),
            "files": {
                covered.label: {
                    "missions": sorted(covered.missions),
                    "score": covered.score.as_dict(),
                    "nodes": [
                        {name: getattr(place, name) for name in names}
                        for place in covered.in_order()
                    ],
                }
                for covered in self.in_order()
            },
        }
