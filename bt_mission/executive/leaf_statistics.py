"""The statistics of each leaf: number of runs, outcomes, time and distance."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.base.stamps import NS
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.events.events import NodeChanged, NodeInfo, TreeRevised
from bt_mission.executive.executive import Executive


@dataclass(frozen=True)
class LeafSummary:
    """The statistics of a leaf.

    Args:
        path: Its place in the tree.
        runs: The number of runs.
        outcomes: The number of each outcome: for a goal that of its leaf (the closed list of the
            mission language), for other leaves success, failure or halted.
        running_s: Virtual time for which it ran, s.
        distance_m: The distance that the robot drove meanwhile, m; None if it is not known.
    """

    name: str
    path: str
    runs: int
    outcomes: Mapping[str, int]
    running_s: float
    distance_m: float | None


@dataclass
class _Sum:
    node: NodeInfo
    running_ns: int = 0
    distance_m: float = 0.0
    begun_m: float | None = None
    outcomes: Counter[str] = field(default_factory=Counter)


class LeafStatistics:
    """Counts from now on.

    Args:
        executive: Of the mission.
        distance_m: Returns the distance that the robot has driven so far, m; None if it is not
            known.
    """

    def __init__(self, executive: Executive, distance_m: Callable[[], float | None]) -> None:
        self._nodes, self._state = executive.nodes, executive.mission_state
        self._distance_m = distance_m
        self._executive = executive
        self._sums: dict[int, _Sum] = {}
        """By the node's index."""
        self._gone: list[_Sum] = []
        """Those of leaves that a revision has removed."""
        executive.events.subscribe(self._take, NodeChanged)
        executive.events.subscribe(self._revise, TreeRevised)

    def _revise(self, event: TreeRevised) -> None:
        now = {index: new for new, index in enumerate(event.kept)}
        self._gone += [leaf for index, leaf in self._sums.items() if index not in now]
        self._sums = {now[index]: leaf for index, leaf in self._sums.items() if index in now}
        for index, leaf in self._sums.items():
            leaf.node = event.nodes[index]
        self._nodes = self._executive.nodes

    def _take(self, event: NodeChanged) -> None:
        if not self._state.is_leaf[event.node]:
            return
        assert self._state.tree is not None, "the executive has sent it"
        leaf = self._sums.setdefault(event.node, _Sum(self._state.tree.nodes[event.node]))
        distance_m = self._distance_m() or 0.0
        if event.status is Status.RUNNING:
            leaf.begun_m = distance_m
        elif event.status is not Status.INVALID or leaf.begun_m is not None:
            leaf.running_ns += self._state.last_end(event.node).ran_ns or 0
            if leaf.begun_m is not None:
                # The length of a path is a sum of pieces; it may be slightly less after a turn.
                leaf.distance_m += max(0.0, distance_m - leaf.begun_m)
            leaf.begun_m = None
            leaf.outcomes[_outcome(self._nodes[event.node], event.status)] += 1

    def summaries(self) -> tuple[LeafSummary, ...]:
        """Those that have ended at least once, in the order of their first start."""
        is_known = self._distance_m() is not None
        return tuple(
            LeafSummary(
                name=leaf.node.name,
                path=leaf.node.path,
                runs=leaf.outcomes.total(),
                outcomes=dict(leaf.outcomes),
                running_s=round(leaf.running_ns / NS, 6),
                distance_m=round(leaf.distance_m, 6) if is_known else None,
            )
            for leaf in (*self._gone, *self._sums.values())
            if leaf.outcomes
        )


def _outcome(node: Behaviour, status: Status) -> str:
    if isinstance(node, ActionLeaf) and node.attempt is not None and node.attempt.ending:
        return str(node.attempt.ending.outcome)
    return "halted" if status is Status.INVALID else str(status.value).lower()
