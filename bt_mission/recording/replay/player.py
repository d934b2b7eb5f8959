"""Plays a timeline: at any speed, forwards and backwards, step by step. Time comes from outside."""

from __future__ import annotations

from bt_mission.core.stamps import NS
from bt_mission.events.mission_state import MissionState
from bt_mission.recording.replay.seeker import TimelineSeeker
from bt_mission.recording.replay.timeline import Timeline

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
        """What was known of the mission at that time; valid until the time is another one."""
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
        """Is there nothing after this?"""
        return self.time_ns >= self.timeline.end_ns

    @property
    def is_at_start(self) -> bool:
        """Is there nothing before this?"""
        return self.time_ns <= self.timeline.start_ns

    def advance(self, wall_s: float) -> bool:
        """Let so much time of the wall pass; gives whether the timeline has moved.

        At an end of the timeline it stops.
        """
        if not self.is_playing:
            return False
        # What is less than a nanosecond of the timeline counts the next time.
        passed, self._rest = divmod(wall_s * self.speed * NS + self._rest, 1)
        self._show(self.time_ns + (-1 if self.is_backwards else 1) * int(passed))
        if self.is_at_start if self.is_backwards else self.is_at_end:
            self.is_playing = False
        return True

    # ---- what the user wants ---------------------------------------------------------------

    def play(self) -> None:
        """Play; once nothing is left in that direction, from the other end."""
        if self.is_backwards and self.is_at_start:
            self.time_ns = self.timeline.end_ns
        elif not self.is_backwards and self.is_at_end:
            self.time_ns = self.timeline.start_ns
        self.is_playing = True

    def pause(self) -> None:
        """Stand still."""
        self.is_playing = False

    def reverse(self) -> None:
        """Play the other way, also where it stood still."""
        self.is_backwards = not self.is_backwards
        self.is_playing = not (self.is_at_start if self.is_backwards else self.is_at_end)

    def faster(self, factor: float) -> None:
        """Play so many times as fast as until now."""
        self.speed = min(max(self.speed * factor, SLOWEST), FASTEST)

    def step(self, steps: int) -> bool:
        """Go to the next change of the tree, or (-1) to the one before, and stay there.

        Gives whether there is one.
        """
        find = self.timeline.change_after if steps > 0 else self.timeline.change_before
        return self._stay(find(self.time_ns))

    def step_to_start(self, node: int, steps: int) -> bool:
        """Go to the instant at which a node starts next, or (-1) last did, and stay there."""
        tree = self.mission.tree
        if tree is None:
            return False
        find = self.timeline.start_after if steps > 0 else self.timeline.start_before
        return self._stay(find(tree.run, node, self.time_ns))

    def skip(self, seconds: float) -> None:
        """Go so far on, or back where that is less than 0."""
        self._show(self.time_ns + round(seconds * NS))

    def go(self, at_s: float) -> None:
        """Go to a time, s since the start of the mission; to an end where that is beyond it."""
        self._show(self.timeline.start_ns + round(min(max(at_s, 0.0), self.duration_s) * NS))

    def _stay(self, time_ns: int | None) -> bool:
        self.is_playing = False
        if time_ns is None:
            return False
        self._show(time_ns)
        return True

    def _show(self, time_ns: int) -> None:
        self.time_ns = min(max(time_ns, self.timeline.start_ns), self.timeline.end_ns)
