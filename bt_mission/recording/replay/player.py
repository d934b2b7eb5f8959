"""Plays a timeline: at any speed, forwards and backwards, step by step.

Time comes from the caller.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from contextlib import suppress

from bt_mission.base.stamps import NS
from bt_mission.executive.events.events import RunStarted
from bt_mission.executive.events.log import LogEntry
from bt_mission.executive.events.messages import ROBOT
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.recording.reading import UNREADABLE
from bt_mission.recording.recorded_messages import RobotMessage
from bt_mission.recording.replay.timeline import Frame, Timeline, beside

SPACING = 500
"""Frames between two kept states: the most that are played again for any instant."""

MOST_KEPT = 256
MOST_NODES = 500_000
"""If a timeline would need more states than this, or more nodes in all of them, the states are kept
farther apart: a node takes some 50 bytes of each.
"""


def entries_of(timeline: Timeline) -> Iterator[LogEntry]:
    """All lines of the log of a timeline."""
    mission = MissionState()
    for frame in timeline.frames:
        if isinstance(frame, (*ROBOT, RobotMessage)) or not mission.apply(frame):
            continue
        if (entry := mission.entry_of(frame)) is not None:
            yield entry


class TimelineSeeker:
    """Returns the state at any instant of a timeline.

    To go back, it takes the last kept state before that instant and plays on from there. So the
    state does not depend on the direction.
    """

    def __init__(self, timeline: Timeline) -> None:
        self.timeline = timeline
        self._state = MissionState()
        self._at = 0
        """The number of frames that have been played."""
        sizes = (len(frame.nodes) for frame in timeline.frames if isinstance(frame, RunStarted))
        most_kept = min(MOST_KEPT, max(MOST_NODES // max(sizes, default=1), 1))
        self._spacing = max(SPACING, len(timeline.frames) // most_kept)
        self._kept = [MissionState()]
        """A state after every `SPACING` frames, as far as the timeline has been played."""

    def seek(self, time_ns: int) -> MissionState:
        """Return the state at this ROS time; the next call changes it."""
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
        """Apply frames; a scan or a map that cannot be read is skipped."""
        newest: dict[str, RobotMessage] = {}
        for frame in frames:
            if isinstance(frame, RobotMessage):
                newest[frame.topic] = frame
            elif isinstance(frame, ROBOT):
                self._state.robot.take(frame)
            else:
                self._state.apply(frame)
        for message in newest.values():
            with suppress(*UNREADABLE):
                self._state.robot.take(message.viewed())


SLOWEST, FASTEST = 1 / 64, 1024.0


class Player:
    """A place in a timeline, and how it moves.

    Args:
        speed: Seconds of the timeline for each of the wall.
        at_s: Where to begin, s since the start of the mission.
    """

    def __init__(self, timeline: Timeline, *, speed: float = 1.0, at_s: float = 0.0) -> None:
        self.timeline = timeline
        self.speed = speed
        self.is_backwards = False
        self.is_playing = False
        self.time_ns = timeline.start_ns
        """The ROS time that is shown, ns."""
        self._seeker = TimelineSeeker(timeline)
        self._rest = 0.0
        self.go(at_s)

    @property
    def mission(self) -> MissionState:
        """The state of the mission at that time; valid until the time changes."""
        return self._seeker.seek(self.time_ns)

    @property
    def at_s(self) -> float:
        """Seconds since the start of the mission."""
        return (self.time_ns - self.timeline.start_ns) / NS

    @property
    def duration_s(self) -> float:
        """Seconds from the start of the mission to the end of the recording."""
        return (self.timeline.end_ns - self.timeline.start_ns) / NS

    @property
    def is_at_end(self) -> bool:
        """Whether this is the end."""
        return self.time_ns >= self.timeline.end_ns

    @property
    def is_at_start(self) -> bool:
        """Whether this is the start."""
        return self.time_ns <= self.timeline.start_ns

    def advance(self, wall_s: float) -> bool:
        """Advance by some wall time. Return whether the timeline has moved.

        It stops at an end of the timeline.
        """
        if not self.is_playing:
            return False
        # What is less than a nanosecond of the timeline counts the next time.
        passed, self._rest = divmod(wall_s * self.speed * NS + self._rest, 1)
        self._show(self.time_ns + (-1 if self.is_backwards else 1) * int(passed))
        if self.is_at_start if self.is_backwards else self.is_at_end:
            self.is_playing = False
        return True

    # ---- requests of the user --------------------------------------------------------------

    def play(self) -> None:
        """Play; at the end in that direction, from the other end."""
        if self.is_backwards and self.is_at_start:
            self.time_ns = self.timeline.end_ns
        elif not self.is_backwards and self.is_at_end:
            self.time_ns = self.timeline.start_ns
        self.is_playing = True

    def pause(self) -> None:
        """Pause."""
        self.is_playing = False

    def reverse(self) -> None:
        """Play the other way, also where it stood still."""
        self.is_backwards = not self.is_backwards
        self.is_playing = not (self.is_at_start if self.is_backwards else self.is_at_end)

    def faster(self, factor: float) -> None:
        """Multiply the speed."""
        self.speed = min(max(self.speed * factor, SLOWEST), FASTEST)

    def step(self, steps: int) -> bool:
        """Go to the next change of the tree, or (-1) to the one before, and stay there.

        Returns whether there is one.
        """
        return self._stay(beside(self.timeline.changes_ns, self.time_ns, steps))

    def step_to_start(self, node: int, steps: int) -> bool:
        """Go to the instant at which a node starts next, or (-1) last did, and stay there."""
        tree = self.mission.tree
        if tree is None:
            return False
        starts_ns = self.timeline.starts_ns.get((tree.run, tree.revision, node), ())
        return self._stay(beside(starts_ns, self.time_ns, steps))

    def skip(self, seconds: float) -> None:
        """Go so far on, or back where that is less than 0."""
        self._show(self.time_ns + round(seconds * NS))

    def go(self, at_s: float) -> None:
        """Go to a time, s since the start of the mission, at most to an end."""
        self._show(self.timeline.start_ns + round(min(max(at_s, 0.0), self.duration_s) * NS))

    def _stay(self, time_ns: int | None) -> bool:
        self.is_playing = False
        if time_ns is None:
            return False
        self._show(time_ns)
        return True

    def _show(self, time_ns: int) -> None:
        self.time_ns = min(max(time_ns, self.timeline.start_ns), self.timeline.end_ns)
