"""Faults of the feedback of actions: none, late, stale, of another goal, or garbage."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any

from unique_identifier_msgs.msg import UUID

from bt_mission.testing.faults.corruptions import changed_by
from bt_mission.testing.faults.fault import Fates, Fault, FaultInstance, Maker, nanoseconds
from bt_mission.testing.faults.goals import part_of
from bt_mission.virtual_time import Delivery, Passing, Side


class FeedbackFaults(Maker):
    """Faults of feedback; ``action`` and ``lasting`` are as those of other faults of actions."""

    def silence_feedback(self, action: str, *, lasting: float | None = None) -> Fault:
        """Lose all feedback."""
        return self._feedback("silence_feedback", lambda _: lambda _passing: (), action, lasting)

    def delay_feedback(self, action: str, by: float, *, lasting: float | None = None) -> Fault:
        """Deliver feedback late, after the end of its goal, too."""
        by_ns = nanoseconds("delay_feedback", by)
        return self._feedback(
            "delay_feedback",
            lambda _: lambda passing: (Delivery(passing.message, after_ns=by_ns),),
            action,
            lasting,
            by=by,
        )

    def freeze_feedback(self, action: str, *, lasting: float | None = None) -> Fault:
        """Send stale feedback: each goal's first again and again, instead of what comes after."""

        def make(_: FaultInstance) -> Callable[[Passing], Fates]:
            first: dict[bytes, Any] = {}

            def freeze(passing: Passing) -> Fates:
                goal = bytes(passing.message.goal_id.uuid)
                return (Delivery(deepcopy(first.setdefault(goal, passing.message))),)

            return freeze

        return self._feedback("freeze_feedback", make, action, lasting)

    def forge_feedback(
        self, action: str, *, instead: bool = False, lasting: float | None = None
    ) -> Fault:
        """Send feedback of another goal, with numbers that are none.

        The other is the goal before, or where there was none, one that nobody has sent.

        :param instead: of the goal's own; else before each of its own.
        """

        def make(fault: FaultInstance) -> Callable[[Passing], Fates]:
            nobodys = fault.generator().randbytes(16)
            known: list[bytes] = []
            corrupt = changed_by("nan", None)

            def forge(passing: Passing) -> Fates:
                goal = bytes(passing.message.goal_id.uuid)
                if goal not in known:
                    known.append(goal)
                number = known.index(goal)
                forged = deepcopy(passing.message)
                forged.goal_id = UUID(uuid=list(known[number - 1] if number else nobodys))
                forged.feedback = corrupt(forged.feedback)
                own = () if instead else (Delivery(passing.message),)
                return (Delivery(forged), *own)

            return forge

        return self._feedback("forge_feedback", make, action, lasting, instead=instead or None)

    def corrupt_feedback(
        self,
        action: str,
        how: str | Callable[[Any], Any] = "nan",
        *,
        field: str | None = None,
        lasting: float | None = None,
    ) -> Fault:
        """Send feedback that is wrong.

        :param how: "nan", "inf", "zeros" or "empty"; or a function that changes the feedback, or
            gives another.
        :param field: only this field, by its dotted name.
        """
        change = changed_by(how, field)

        def make(_: FaultInstance) -> Callable[[Passing], Fates]:
            def corrupt(passing: Passing) -> Fates:
                passing.message.feedback = change(passing.message.feedback)
                return (Delivery(passing.message),)

            return corrupt

        return self._feedback("corrupt_feedback", make, action, lasting, how=how, field=field)

    def _feedback(
        self,
        what: str,
        make: Callable[[FaultInstance], Callable[[Passing], Fates]],
        action: str,
        lasting: float | None,
        **parameters: Any,
    ) -> Fault:
        def begin(fault: FaultInstance) -> None:
            fault.tap(part_of(fault, action, "feedback"), Side.MESSAGE, make(fault))

        return self._fault(what, begin, lasting, action=action, **parameters)
