"""The arbiter: several sources of commands for one base, in order of their rank.

Pure: times are nanoseconds of the caller's clock.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from action_servers.core.maneuver import ZERO
from bt_mission.base.geometry import Twist2D


@dataclass(frozen=True, slots=True)
class CommandSource:
    """A topic of commands. It is active until `timeout_s` after its last message.

    Every message of a source that `stops` means zero velocity.
    """

    topic: str
    timeout_s: float
    stops: bool = False


SOURCES = (
    CommandSource("cmd_vel_stop", 0.5, stops=True),
    CommandSource("cmd_vel_joy", 0.5),
    # Servers command 20 times a second. Three missed commands, and the 0.26 s of braking from full
    # speed, let a base stop within 0.5 s after its servers have died. The time counts from the
    # sending of a command, and so does the base's timeout: they do not add up.
    CommandSource("cmd_vel_mission", 0.15),
)
"""From the highest rank to the lowest."""

WINDOW_NS = 2_000_000_000
"""Time, ns, over which the fastest way of a command to the arbiter is looked for."""


class CommandAge:
    """The age of a source's commands, by their stamps.

    The clocks of source and arbiter need not agree. The difference between arrival and stamp grows
    with the delay of a command, compared with the fastest of the last :data:`WINDOW_NS`, or with
    the one before it. A source's clock that is set is followed after that time.
    """

    def __init__(self) -> None:
        self._differences: deque[tuple[int, int]] = deque()

    def of(self, stamp_ns: int, now_ns: int) -> int:
        """Return the age of a command that arrives now, ns; 0 without a stamp."""
        if stamp_ns == 0:
            return 0
        seen, difference = self._differences, now_ns - stamp_ns
        while len(seen) > 1 and not 0 <= now_ns - seen[0][0] < WINDOW_NS:
            seen.popleft()
        while seen and seen[-1][1] >= difference:
            seen.pop()
        seen.append((now_ns, difference))
        return difference - seen[0][1]


class Arbiter:
    """Lets the highest source through that has spoken within its timeout.

    Args:
        sources: From the highest rank to the lowest.
    """

    def __init__(self, sources: Sequence[CommandSource] = SOURCES) -> None:
        self._sources = {source.topic: source for source in sources}
        self._command_ns: dict[str, int] = {}

    def leader(self, now_ns: int) -> str | None:
        """Return the topic that drives, or None if none does."""
        return next((topic for topic in self._sources if self._counts(topic, now_ns)), None)

    def take(self, topic: str, twist: Twist2D, now_ns: int, age_ns: int = 0) -> Twist2D | None:
        """Handle a command. Return the twist to send at once, or None if a higher source drives.

        A command counts from when it was sent, `age_ns` ago; a late one has no effect. A command of
        a source that `stops` always has an effect. Raises ValueError for a command that is not
        finite; the source then counts as silent.
        """
        if not twist.is_finite:
            raise ValueError(f"{topic} commanded {twist}")
        stops = self._sources[topic].stops
        self._command_ns[topic] = now_ns if stops else now_ns - age_ns
        if self.leader(now_ns) != topic:
            return None
        return ZERO if stops else twist

    def step(self, now_ns: int) -> Twist2D | None:
        """Return zero velocity while no source drives, else None. Call it periodically."""
        return ZERO if self.leader(now_ns) is None else None

    def _counts(self, topic: str, now_ns: int) -> bool:
        command_ns = self._command_ns.get(topic)
        if command_ns is None:
            return False
        # A clock that was set back invalidates the earlier times.
        return 0 <= now_ns - command_ns < self._sources[topic].timeout_s * 1e9
