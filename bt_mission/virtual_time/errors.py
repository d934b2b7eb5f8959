"""What keeps virtual time from moving."""

from __future__ import annotations

from bt_mission.core.errors import BtMissionError


class TimeStuckError(BtMissionError):
    """Callbacks keep each other busy, so virtual time cannot advance."""


class NothingDueError(BtMissionError):
    """There is neither a timer nor a world that could move time."""

    def __init__(self) -> None:
        super().__init__("virtual time cannot move: no timer is set and there is no world")


class NestedStepError(BtMissionError):
    """A callback asked for time to move, which waits for the callback to end."""

    def __init__(self) -> None:
        super().__init__(
            "a callback cannot spin: virtual time moves only when all callbacks have returned; "
            "make it `async def`, and await the future"
        )
