"""A mission of another process as plain lines, also one that is joined in the middle."""

from __future__ import annotations

from collections.abc import Iterator

from bt_mission.executive.events.events import (
    Event,
    NodeChanged,
    RequirementChanged,
    RunStarted,
    TreeRevised,
)
from bt_mission.executive.events.feed import MissionFeed
from bt_mission.executive.events.messages import Batch
from bt_mission.views.terminal.lines import RequirementLines, log_line, whole_tree
from bt_mission.views.terminal.marks import Marks


class FollowedLines:
    """The lines of a mission that is watched.

    A tree is shown once the statuses of its nodes are known.

    Args:
        feed: Takes the messages.
    """

    def __init__(self, feed: MissionFeed, marks: Marks) -> None:
        self._feed, self._marks = feed, marks
        self._requirements = RequirementLines()
        self._held: list[str] | None = None
        """Lines of a tree and after it, while the statuses are not known."""
        self._is_joined = False
        """Have nodes of that tree changed before it was received?"""

    def take(self, batch: Batch) -> Iterator[str]:
        """Handle a message; yield the lines that are due."""
        for event in self._feed.take(batch):
            if isinstance(event, RunStarted | TreeRevised):
                yield from self._held or ()
                self._held, self._is_joined = [*self._tree(event)], False
                self._requirements = RequirementLines(self._feed.mission.requirements)
            elif self._held is None:
                yield from self._lines(event)
            else:
                self._held += self._lines(event)
                self._is_joined |= isinstance(event, NodeChanged) and event.time_ns is None
        if self._held is not None and self._feed.sequence is not None:
            mission = self._feed.mission
            yield from whole_tree(mission, self._marks, None) if self._is_joined else self._held
            self._held = None

    def _lines(self, event: Event) -> Iterator[str]:
        mission = self._feed.mission
        if isinstance(event, RequirementChanged):
            yield from self._requirements.take(event, mission.tree)
        elif (entry := mission.entry_of(event)) is not None and mission.tree is not None:
            yield log_line(entry, mission.tree.time_ns, self._marks)

    def _tree(self, event: RunStarted | TreeRevised) -> Iterator[str]:
        """Yield every node of a mission that has started or was revised."""
        mission = self._feed.mission
        entry = mission.entry_of(event)
        if isinstance(event, TreeRevised) and entry is not None and mission.tree is not None:
            yield log_line(entry, mission.tree.time_ns, self._marks)
        yield from whole_tree(mission, self._marks, None)
