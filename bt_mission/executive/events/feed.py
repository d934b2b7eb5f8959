"""The messages of an executive in another process, put in order for a mission's state.

Messages may arrive late and out of order: the tree after its first changes, changes with gaps.
Changes are applied once all earlier statuses are known; until then they wait.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import replace

from bt_mission.executive.events.events import FINAL, Event, RunStarted, StateChanged, TreeRevised
from bt_mission.executive.events.messages import Batch
from bt_mission.executive.events.mission_state import MissionState

MOST_WAITING = 10_000
"""The number of messages that wait for earlier ones; beyond it the oldest are dropped."""


class MissionFeed:
    """Applies batches of events to a state.

    Args:
        mission: The state.
    """

    def __init__(self, mission: MissionState) -> None:
        self.mission = mission
        self.sequence: int | None = None
        """The number of the newest changes that are known; None while statuses are not known."""
        self._waiting: deque[Batch] = deque(maxlen=MOST_WAITING)
        self._early: deque[Batch] = deque(maxlen=MOST_WAITING)
        """Messages of a run whose tree has not arrived yet."""

    @property
    def needs_statuses(self) -> bool:
        """Whether all statuses have to be requested."""
        return self.mission.tree is not None and self.sequence is None

    def take(self, batch: Batch) -> list[Event]:
        """Handle a message. Return the events that change the state, in order."""
        return list(self._taken(batch))

    def _taken(self, batch: Batch) -> Iterator[Event]:
        mission = self.mission
        match batch.events:
            case (RunStarted() as tree,):
                yield from self._begin(tree)
                return
            case (TreeRevised() as revised,):
                yield from self._revise(revised)
                return
            case (StateChanged(),):  # also of a run whose tree has not arrived
                yield from self._apply(batch.events)
                return
        if mission.tree is None or batch.run != mission.tree.run:
            self._early.append(batch)
        elif (batch.sequence or batch.is_complete) and batch.revision != mission.tree.revision:
            if batch.revision > mission.tree.revision:
                self._early.append(batch)
            else:  # of an earlier tree: its changes are in the statuses of all nodes
                self.sequence = None
        elif batch.is_complete:
            yield from self._take_statuses(batch)
        elif batch.sequence:
            self._waiting.append(batch)
            yield from self._catch_up()
        else:
            yield from self._apply(batch.events)

    def _begin(self, tree: RunStarted) -> Iterator[Event]:
        if not self.mission.apply(tree):
            return
        self.sequence = None
        yield tree
        yield from self._take_early(tree.run)

    def _revise(self, revised: TreeRevised) -> Iterator[Event]:
        tree = self.mission.tree
        if tree is None or tree.run != revised.run:
            yield from self._begin(revised.as_start())
            return
        if revised.number <= tree.revision:
            return
        if revised.number > tree.revision + 1:  # one between them was lost
            lost = replace(revised, kept=(-1,) * len(revised.nodes))
            self.mission.apply(lost)
            self.sequence = None
        else:
            self.mission.apply(revised)
        if self._waiting:
            self.sequence = None
        yield revised
        yield from self._take_early(revised.run)

    def _take_early(self, run: str) -> Iterator[Event]:
        self._waiting.clear()
        batches = [batch for batch in self._early if batch.run == run]
        self._early.clear()
        for batch in batches:
            yield from self._taken(batch)

    def _catch_up(self) -> Iterator[Event]:
        """Apply the changes that follow what is known."""
        while self._waiting:
            batch = self._waiting[0]
            # Before the first changes of a run nothing has happened.
            known = 0 if self.sequence is None and batch.sequence == 1 else self.sequence
            if known is None or batch.sequence > known + 1:
                self.sequence = None
                return
            self._waiting.popleft()
            if batch.sequence == known + 1:
                self.sequence = batch.sequence
                yield from self._apply(batch.events)

    def _take_statuses(self, batch: Batch) -> Iterator[Event]:
        if self.sequence is not None and batch.sequence < self.sequence:
            return  # older than what has arrived since
        self.sequence = batch.sequence
        progress = tuple(self.mission.progress.values())
        yield from self._apply(batch.events)
        for event in progress:
            self.mission.note_progress(event)
        yield from self._catch_up()

    def _apply(self, events: Iterable[Event]) -> Iterator[Event]:
        for event in events:
            if self.mission.apply(event):
                yield event


def in_order(batches: Iterable[Batch]) -> list[Batch]:
    """Put the end of a mission after everything else of a message; topics may overtake."""
    ordered = list(batches)
    for batch in tuple(ordered):
        if any(isinstance(event, StateChanged) and event.status in FINAL for event in batch.events):
            last = max(at for at, other in enumerate(ordered) if other.run == batch.run)
            ordered.insert(last + 1, batch)
            ordered.remove(batch)
    return ordered
