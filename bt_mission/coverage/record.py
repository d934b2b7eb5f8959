"""What one run has reached of its mission, small enough to be kept for each of very many runs."""

from __future__ import annotations

from typing import Self

from bt_mission.coverage.places import Built, places
from bt_mission.coverage.watch import BRANCH, OUTCOME, REACHED, CoverageWatch
from bt_mission.executive.executive import Executive
from bt_mission.language.mission import Mission


def coverage_places(mission: Mission) -> tuple[str, ...]:
    """Name everything that there is to reach in a mission.

    A name is that of a node with its place in the tree, and what of it: ``0.1 drive: reached``,
    ``0.1 drive: outcome canceled by condition``, ``0.2 way out: branch 2 turn``. Before the place
    in a named tree stands the tree: ``half:0.1``. Names differ, and depend with their order on the
    trees of the mission alone: not on its inputs, its seed or the machine.
    """
    return tuple(name for name, _ in _named(mission))


def _named(mission: Mission) -> list[tuple[str, tuple[int, str, str]]]:
    """Each name, with the node's step (by its identity), what of it, and which."""
    found = []
    for place in places(mission):
        node = f"{place.tree}:{place.path}" if place.tree else place.path
        marks = [
            (REACHED, ""),
            *((OUTCOME, one) for one in place.outcomes),
            *((BRANCH, one) for one in place.branches),
        ]
        found += [
            (f"{node} {place.name}: {what} {which}".rstrip(), (id(place.step), what, which))
            for what, which in marks
        ]
    return found


class CoverageRecord:
    """What was reached of the places of a mission, by one run or several.

    ``a | b`` is what either has reached, of two records of the same places.

    Args:
        places: What there is to reach, as `coverage_places` gives it.
        bits: What was reached: bit ``n`` of the number stands for the place of index ``n``.
    """

    def __init__(self, places: tuple[str, ...], bits: int = 0) -> None:
        self.places = places
        self.bits = bits

    @classmethod
    def attach(cls, mission: Mission, executive: Executive) -> Self:
        """Record what a run reaches from now on; call it before the first tick."""
        named = _named(mission)
        record = cls(tuple(name for name, _ in named))
        numbers = {key: number for number, (_, key) in enumerate(named)}

        def mark(one: Built, what: str, which: str) -> None:
            number = numbers.get((id(one.step), what, which))
            if number is not None:
                record.bits |= 1 << number

        CoverageWatch(mission, executive, mark)
        return record

    @classmethod
    def from_hex(cls, places: tuple[str, ...], text: str) -> Self:
        """Read what `as_hex` has written.

        Raises:
            ValueError: When the text is not that of a record of so many places.
        """
        bits = int(text, 16) if text else 0
        if len(text) != _digits(places) or bits >> len(places):
            raise ValueError(f"expected {_digits(places)} hexadecimal digits, got {text!r}")
        return cls(places, bits)

    def as_hex(self) -> str:
        """What was reached in hexadecimal digits: four places in each, the first in the last."""
        width = _digits(self.places)
        return f"{self.bits:0{width}x}" if width else ""

    @property
    def reached(self) -> tuple[str, ...]:
        """The places that were reached, in their order."""
        return tuple(name for n, name in enumerate(self.places) if self.bits >> n & 1)

    @property
    def missing(self) -> tuple[str, ...]:
        """The places that were not."""
        return tuple(name for n, name in enumerate(self.places) if not self.bits >> n & 1)

    @property
    def percent(self) -> float:
        """How much of what there is was reached; of nothing, all is."""
        return 100 * self.bits.bit_count() / len(self.places) if self.places else 100.0

    def __or__(self, other: CoverageRecord) -> CoverageRecord:
        if other.places != self.places:
            raise ValueError("two records of different places cannot be united")
        return CoverageRecord(self.places, self.bits | other.bits)


def _digits(places: tuple[str, ...]) -> int:
    return -(-len(places) // 4)
