"""What of the tree all runs together have reached, and how often."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

REACHED = ": reached"
_OF_MISSION = re.compile(r"(?P<place>\d+(?:\.\d+)*) (?P<name>.*)", re.DOTALL)
_OF_TREE = re.compile(r"(?P<place>.*?:\d+(?:\.\d+)*) (?P<name>.*)", re.DOTALL)


@dataclass(frozen=True)
class ReachedNode:
    """A node, with the number of runs that have reached it, its outcomes and its branches.

    Attributes:
        place: Where it stands in its tree, such as ``0.1`` or ``half:0.1``.
        ways: Outcomes and branches with the runs that have had them.
    """

    place: str
    name: str
    runs: int
    ways: dict[str, int] = field(default_factory=dict)

    @property
    def depth(self) -> int:
        """How many nodes of its tree are above it."""
        return self.place.rpartition(":")[2].count(".")


def reached_nodes(places: tuple[str, ...], bitmaps: Mapping[str, int]) -> list[ReachedNode]:
    """Add the bitmaps of all runs up.

    Args:
        places: As `coverage_places` names them.
        bitmaps: How often each came out, as `CoverageRecord` writes them.
    """
    runs = [0] * len(places)
    for text, count in bitmaps.items():
        bits = int(text, 16) if text else 0
        for number in range(len(places)):
            if bits >> number & 1:
                runs[number] += count
    found: list[ReachedNode] = []
    for name, count in zip(places, runs, strict=True):
        if name.endswith(REACHED):
            node = name.removesuffix(REACHED)
            parts = _OF_MISSION.fullmatch(node) or _OF_TREE.fullmatch(node)
            place, called = (parts["place"], parts["name"]) if parts else ("", node)
            found.append(ReachedNode(place, called, count))
        elif found:
            one = found[-1]
            found[-1].ways[name.removeprefix(f"{one.place} {one.name}: ")] = count
    return found
