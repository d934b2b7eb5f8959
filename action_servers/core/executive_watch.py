"""The liveliness of executives, which DDS reports: pure.

An executive whose sign of life is late may have died, or the machine or the network is busy. So the
base is held at once, and goals end only if the sign of life stays away.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from bt_mission.base.dds.liveliness import LEASE_S, TIMEOUT_S
from bt_mission.base.parameters import number

LOOK_S = 0.1
"""The interval of :meth:`ExecutiveWatch.look` while an executive is late, s. Looks are counted, not
time: a server that is delayed itself does not take the executive for dead.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class ExecutiveLimits:
    """The limits of an executive without a sign of life, s of the wall clock."""

    executive_lease: float = number(
        LEASE_S,
        (LEASE_S, 10.0),
        "Time without a sign of life of an executive after which the base is held, s. With the "
        "0.26 s of braking from full speed, it stands within 0.5 s.",
        is_fixed=True,
    )
    executive_timeout: float = number(
        TIMEOUT_S,
        (LEASE_S, 600.0),
        "Time without a sign of life of an executive after which every goal is aborted, s.",
        is_fixed=True,
    )


class ExecutiveWatch:
    """Counts executives that are alive, late and given up.

    Args:
        limits: The time until one is late, for messages, and until it is given up.
        on_late: Called with the reason when one is late.
        on_back: Called when none is late any more.
        on_lost: Called with the reason when one is given up, and when the last one leaves.
    """

    def __init__(
        self,
        limits: ExecutiveLimits,
        on_late: Callable[[str], None],
        on_back: Callable[[], None],
        on_lost: Callable[[str], None],
    ) -> None:
        self._limits = limits
        self._on_late, self._on_back, self._on_lost = on_late, on_back, on_lost
        self._alive = 0
        self._not_alive = 0
        self._given_up = 0
        self._looks = 0

    @property
    def late(self) -> int:
        """The number of executives that are late and not given up."""
        return self._not_alive - self._given_up

    def update(self, alive: int, not_alive: int) -> None:
        """Take in how many executives give a sign of life now, and how many do not."""
        has_left = alive + not_alive < self._alive + self._not_alive
        late_before = self.late
        has_left_late = has_left and not_alive < self._not_alive and alive <= self._alive
        self._alive, self._not_alive = alive, not_alive
        self._given_up = min(self._given_up, not_alive)
        if self.late > late_before:
            self._looks = 0
            lease_s = self._limits.executive_lease
            self._on_late(f"no sign of life of the executive for {lease_s:g} s: the base is held")
        elif late_before and has_left_late:
            self._lose("the executive has gone while its sign of life was late")
        elif has_left and not alive and not self.late:
            self._on_lost("the executive has left")
        if late_before and not self.late:
            self._on_back()

    def look(self) -> None:
        """Give those up that have been late for too long."""
        if not self.late:
            return
        self._looks += 1
        since_s = self._limits.executive_lease + self._looks * LOOK_S
        if since_s >= self._limits.executive_timeout - LOOK_S / 2:
            limit_s = self._limits.executive_timeout
            self._lose(f"the executive has died: no sign of life for {limit_s:g} s")
            self._on_back()

    def _lose(self, why: str) -> None:
        self._given_up = self._not_alive
        self._on_lost(why)
