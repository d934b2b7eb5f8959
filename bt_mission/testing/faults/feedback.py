"""Faults of the feedback of actions: none, late, stale, of another goal, or garbage."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any

from unique_identifier_msgs.msg import UUID

from bt_mission.testing.faults.corruptions import changed_by
from bt_mission.testing.faults.fault import Begin, Fates, FaultInstance, Tap
from bt_mission.testing.faults.goals import tap_parts
from bt_mission.testing.faults.maker import Maker, makes_fault
from bt_mission.testing.faults.taps import later, lost
from bt_mission.virtual_time import Delivery, Passing, Side


class FeedbackFaults(Maker):
    """Faults of feedback; ``action`` and ``lasting`` are as those of other faults of actions."""

    @makes_fault
    def silence_feedback(self, action: str, *, lasting: float | None = None) -> Begin:
        """Lose all feedback."""
        return _feedback(action, lost)

    @makes_fault
    def delay_feedback(self, action: str, by: float, *, lasting: float | None = None) -> Begin:
        """Deliver feedback late, after the end of its goal, too."""
        return _feedback(action, later("delay_feedback", by))

    @makes_fault
    def freeze_feedback(self, action: str, *, lasting: float | None = None) -> Begin:
        """Send stale feedback: each goal's first again and again, instead of what comes after."""

        def freeze(fault: FaultInstance, passing: Passing) -> Fates:
            goal = bytes(passing.message.goal_id.uuid)
            return (Delivery(deepcopy(fault.kept.setdefault(goal, passing.message))),)

        return _feedback(action, freeze)

    @makes_fault
    def forge_feedback(
        self, action: str, *, instead: bool = False, lasting: float | None = None
    ) -> Begin:
        """Send feedback of another goal, with numbers that are none.

        The other is the goal before, or where there was none, one that nobody has sent.

        Args:
            instead: Of the goal's own; else before each of its own.
        """
        corrupt = changed_by("nan", None)

        def forge(fault: FaultInstance, passing: Passing) -> Fates:
            goal = bytes(passing.message.goal_id.uuid)
            known = list(fault.kept) or [fault.generator().randbytes(16)]
            other = fault.kept.setdefault(goal, known[-1])
            forged = deepcopy(passing.message)
            forged.goal_id = UUID(uuid=list(other))
            forged.feedback = corrupt(forged.feedback)
            own = () if instead else (Delivery(passing.message),)
            return (Delivery(forged), *own)

        return _feedback(action, forge)

    @makes_fault
    def corrupt_feedback(
        self,
        action: str,
        how: str | Callable[[Any], Any] = "nan",
        *,
        field: str | None = None,
        lasting: float | None = None,
    ) -> Begin:
        """Send feedback that is wrong.

        Args:
            how: "nan", "inf", "zeros" or "empty"; or a function that changes the feedback, or gives
                another.
            field: Only this field, by its dotted name.
        """
        change = changed_by(how, field)

        def corrupt(_: FaultInstance, passing: Passing) -> Fates:
            passing.message.feedback = change(passing.message.feedback)
            return (Delivery(passing.message),)

        return _feedback(action, corrupt)


def _feedback(action: str, tap: Tap) -> Begin:
    return tap_parts(action, tap, ("feedback", Side.MESSAGE))
