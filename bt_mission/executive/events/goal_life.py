"""The life of a goal, as its executive reports it."""

from __future__ import annotations

from dataclasses import dataclass, field

from bt_mission.executive.events.events import GoalChanged


@dataclass(eq=False)
class GoalLife:
    """A goal and its changes so far.

    Attributes:
        action: Resolved name of the action.
        owner: Name of the leaf.
        changes: The changes with their times, ns.
    """

    id: str
    action: str
    owner: str = ""
    changes: list[tuple[int, GoalChanged]] = field(default_factory=list)

    def take(self, event: GoalChanged, time_ns: int) -> None:
        """Add a change."""
        self.owner = event.owner
        self.changes.append((time_ns, event))

    def change_ns(self, *changes: str) -> int | None:
        """Return the time of the first of these changes; None without one."""
        return next((time_ns for time_ns, event in self.changes if event.change in changes), None)
