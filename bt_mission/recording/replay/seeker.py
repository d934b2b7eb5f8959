"""What is known of a mission at one instant of a timeline, and how it got there."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator

from bt_mission.events.events import MissionStarted
from bt_mission.events.log import LogEntry, entry_of
from bt_mission.events.mission_state import ROBOT, MissionState
from bt_mission.recording.replay.timeline import Frame, LazyMessage, Timeline

SPACING = 500
"""Frames between two states that are kept: so many are played again at most to get anywhere."""

MOST_KEPT = 256
MOST_NODES = 500_000
"""Where a timeline would need more states than so many, or more nodes in all of them, they are kept
farther apart: a node takes some 50 bytes of each."""


def entries_of(timeline: Timeline) -> Iterator[LogEntry]:
    """All lines of the log of a timeline."""
    mission = MissionState()
    for frame in timeline.frames:
        if not isinstance(frame, (*ROBOT, LazyMessage)):
            for happening in mission.take(frame):
                if (entry := entry_of(happening)) is not None:
                    yield entry


def _most_kept(timeline: Timeline) -> int:
    sizes = (len(one.nodes) for one in timeline.frames if isinstance(one, MissionStarted))
    return min(MOST_KEPT, max(MOST_NODES // max(sizes, default=1), 1))


class TimelineSeeker:
    """Gives the state at any instant of a timeline.

    To go back, it takes the last state that it has kept before that instant and plays on from
    there; so an instant is the same from wherever one comes.
    """

    def __init__(self, timeline: Timeline) -> None:
        self.timeline = timeline
        self._state = MissionState()
        self._at = 0
        """So many frames have been played."""
        self._spacing = max(SPACING, len(timeline.frames) // _most_kept(timeline))
        self._kept = [MissionState()]
        """After every so many frames; as far as the timeline has been played."""

    def seek(self, time_ns: int) -> MissionState:
        """The state at this ROS time; it is changed by the next call."""
        wanted = bisect_right(self.timeline.times_ns, time_ns)
        kept = min(wanted // self._spacing, len(self._kept) - 1)
        if wanted < self._at or kept * self._spacing > self._at:
            self._state, self._at = self._kept[kept].copied(), kept * self._spacing
        while self._at < wanted:
            end = min(wanted, (self._at // self._spacing + 1) * self._spacing)
            self._play(self.timeline.frames[self._at : end])
            self._at = end
            if end == len(self._kept) * self._spacing:
                self._kept.append(self._state.copied())
        self._state.now_ns = max(time_ns, self.timeline.start_ns)
        return self._state

    def _play(self, frames: tuple[Frame, ...]) -> None:
        newest: dict[str, LazyMessage] = {}
        for frame in frames:
            if isinstance(frame, LazyMessage):
                newest[frame.topic] = frame
            else:
                self._state.take(frame)
        for message in newest.values():
            seen = message.decode()
            if seen is not None:
                self._state.take(seen)
