"""What each leaf of a mission came to: how often it ran, how that ended, how long and how far."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.behaviours.action_leaf import ActionLeaf
from bt_mission.core.stamps import NS
from bt_mission.events.events import Event, NodeChanged
from bt_mission.executive.executive import Executive


@dataclass(frozen=True)
class LeafSummary:
    """What a leaf came to.

    Args:
        path: Its place in the tree.
        runs: How often it has run.
        outcomes: How often each way in which it ended; of a goal as its leaf saw it (the closed
            list of the mission language), of other leaves success, failure or halted.
        running_s: Virtual time for which it ran, s.
        distance_m: What the robot drove meanwhile, m; None where that is not known.
    """

    name: str
    path: str
    runs: int
    outcomes: Mapping[str, int]
    running_s: float
    distance_m: float | None


@dataclass
class _Sum:
    running_ns: int = 0
    distance_m: float = 0.0
    outcomes: Counter[str] = field(default_factory=Counter)


class LeafStatistics:
    """Counts from now on.

    Args:
        executive: Of the mission.
        distance_m: Gives what the robot has driven so far, m; None where that is not known.
    """

    def __init__(self, executive: Executive, distance_m: Callable[[], float | None]) -> None:
        self._executive = executive
        self._distance_m = distance_m
        self._sums: dict[int, _Sum] = {}
        """By the node's index."""
        self._begun: dict[int, tuple[int, float]] = {}
        executive.events.subscribe(self._take)

    def _take(self, event: Event) -> None:
        if not isinstance(event, NodeChanged) or event.time_ns is None:
            return
        index, node, time_ns = event.node, self._executive.nodes[event.node], event.time_ns
        if node.children:
            return
        if event.status is Status.RUNNING:
            self._sums.setdefault(index, _Sum())
            self._begun[index] = time_ns, self._distance_m() or 0.0
        elif event.status is not Status.INVALID or index in self._begun:
            # What was never seen running began and ended within one tick.
            begun_ns, begun_m = self._begun.pop(index, (time_ns, self._distance_m() or 0.0))
            one = self._sums.setdefault(index, _Sum())
            one.running_ns += time_ns - begun_ns
            # The length of a way is summed in pieces, and may be a hair less at the end of a turn.
            one.distance_m += max(0.0, (self._distance_m() or 0.0) - begun_m)
            one.outcomes[_outcome(node, event.status)] += 1

    def summaries(self) -> tuple[LeafSummary, ...]:
        """Those that have ended at least once, in the order of their first start."""
        is_known = self._distance_m() is not None
        infos = self._executive.node_infos
        return tuple(
            LeafSummary(
                name=infos[index].name,
                path=infos[index].path,
                runs=one.outcomes.total(),
                outcomes=dict(one.outcomes),
                running_s=round(one.running_ns / NS, 6),
                distance_m=round(one.distance_m, 6) if is_known else None,
            )
            for index, one in self._sums.items()
            if one.outcomes
        )


def _outcome(node: Behaviour, status: Status) -> str:
    if isinstance(node, ActionLeaf) and node.attempt is not None and node.attempt.ending:
        return str(node.attempt.ending.outcome)
    return "halted" if status is Status.INVALID else str(status.value).lower()
