"""Faults of action servers: what becomes of goals, cancels, answers and results on their way.

They are the same for servers of ours, for those that a test plays, and for any other: what passes
between a server and its client is caught.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any, Literal

from action_msgs.srv import CancelGoal
from unique_identifier_msgs.msg import UUID

from bt_mission.events.events import Event, GoalChanged
from bt_mission.faults.corruptions import ReadyMadeName, changed_by, setting
from bt_mission.faults.errors import ScenarioError
from bt_mission.faults.fault import Begin, Fates, FaultInstance, Tap
from bt_mission.faults.maker import (
    Maker,
    for_first,
    later,
    lost,
    makes_fault,
    nanoseconds,
    repeated,
)
from bt_mission.faults.parameters import ActionText, Seconds
from bt_mission.virtual_time import ACTION_PARTS, Answer, Delivery, Gate, Passing, Side

PARTS = ("goal", "cancel", "result")
"""The services of an action."""


class GoalFaults(Maker):
    """Faults between an action server and its clients.

    Arguments that they share: ``action``, its name, or a short name of the mission language;
    ``goals``, how many are concerned (None is all), after which the fault ends; ``lasting``, for
    how many seconds. An action that nobody offers is a ScenarioError when the fault begins.
    """

    @makes_fault
    def reject_goals(
        self, action: ActionText, goals: int | None = None, *, lasting: Seconds | None = None
    ) -> Begin:
        """Reject the next goals."""
        reject = for_first("reject_goals", goals, lambda fault, _: (fault.kept["rejection"],))

        def begin(fault: FaultInstance) -> None:
            response = fault.action_type(action).Impl.SendGoalService.Response
            fault.kept["rejection"] = Answer(response(accepted=False))
            fault.tap(part_of(fault, action, "goal"), Side.REQUEST, reject)

        return begin

    @makes_fault
    def ignore_goals(
        self, action: ActionText, goals: int | None = None, *, lasting: Seconds | None = None
    ) -> Begin:
        """Lose goals before the server hears of them: it never answers, and does nothing."""
        tap = for_first("ignore_goals", goals, lost)
        return tap_parts(action, tap, ("goal", Side.REQUEST))

    @makes_fault
    def drop_answers(
        self, action: ActionText, goals: int | None = None, *, lasting: Seconds | None = None
    ) -> Begin:
        """Lose the answers to goals: the server carries them out, and nobody knows of it."""
        tap = for_first("drop_answers", goals, lost)
        return tap_parts(action, tap, ("goal", Side.RESPONSE))

    @makes_fault
    def delay_answers(
        self,
        action: ActionText,
        by: Seconds,
        goals: int | None = None,
        *,
        lasting: Seconds | None = None,
    ) -> Begin:
        """Deliver the answers to goals late; meanwhile the server carries them out."""
        tap = for_first("delay_answers", goals, later("delay_answers", by))
        return tap_parts(action, tap, ("goal", Side.RESPONSE))

    @makes_fault
    def answer_after_halt(
        self,
        action: ActionText,
        *,
        after: Seconds = 0.0,
        at_most: Seconds | None = None,
        lasting: Seconds | None = None,
    ) -> Begin:
        """Hold the answer to a goal back until the client no longer wants the goal.

        Args:
            after: Seconds from there to the answer.
            at_most: So many seconds, where the client goes on wanting it.
        """
        after_ns = nanoseconds("after", after)
        most_ns = None if at_most is None else nanoseconds("at_most", at_most)

        def begin(fault: FaultInstance) -> None:
            name = fault.action(action)
            clock = fault.run.stage.clock
            gates: list[Gate] = []

            def hold(_: FaultInstance, passing: Passing) -> Fates:
                gates.append(gate := Gate())
                if most_ns is not None:
                    gate.open(passing.time_ns + most_ns)
                return (Delivery(passing.message, gate=gate),)

            def take(event: Event) -> None:
                match event:
                    case GoalChanged(action=action, change="released") if action == name:
                        release(after_ns)

            def release(by_ns: int) -> None:
                for gate in gates:
                    gate.open(clock.now_ns + by_ns)

            events = fault.run.robot_run.executive.events
            events.subscribe(take)
            fault.undo(lambda: events.unsubscribe(take))
            fault.undo(lambda: release(0))
            fault.tap(part_of(fault, action, "goal"), Side.RESPONSE, hold)

        return begin

    @makes_fault
    def repeat_answers(
        self,
        action: ActionText,
        part: Literal["goal", "cancel", "result"] = "goal",
        *,
        times: int = 2,
        after: Seconds = 0.0,
        lasting: Seconds | None = None,
    ) -> Begin:
        """Answer more than once.

        Args:
            part: Of the action: ``goal``, ``cancel`` or ``result``.
            after: Seconds from each answer to the next.
        """
        if part not in PARTS:
            raise ScenarioError(
                f"repeat_answers: expected a part of {', '.join(PARTS)}, got '{part}'"
            )
        tap = repeated("repeat_answers", times, after)
        return tap_parts(action, tap, (part, Side.RESPONSE))

    @makes_fault
    def delay_results(
        self,
        action: ActionText,
        by: Seconds,
        goals: int | None = None,
        *,
        lasting: Seconds | None = None,
    ) -> Begin:
        """Deliver results late: the server has ended the goal, the client waits."""
        tap = for_first("delay_results", goals, later("delay_results", by))
        return tap_parts(action, tap, ("result", Side.RESPONSE))

    @makes_fault
    def drop_results(
        self, action: ActionText, goals: int | None = None, *, lasting: Seconds | None = None
    ) -> Begin:
        """Lose results for ever."""
        tap = for_first("drop_results", goals, lost)
        return tap_parts(action, tap, ("result", Side.RESPONSE))

    @makes_fault
    def refuse_cancels(
        self, action: ActionText, times: int | None = None, *, lasting: Seconds | None = None
    ) -> Begin:
        """Refuse requests to cancel; the server does not hear of them.

        Args:
            times: So often; None is always.
        """
        refusal = Answer(CancelGoal.Response(return_code=CancelGoal.Response.ERROR_REJECTED))
        tap = for_first("refuse_cancels", times, lambda *_: (refusal,))
        return tap_parts(action, tap, ("cancel", Side.REQUEST))

    @makes_fault
    def ignore_cancels(
        self, action: ActionText, times: int | None = None, *, lasting: Seconds | None = None
    ) -> Begin:
        """Lose requests to cancel: the server goes on, and does not answer.

        Args:
            times: So many; None is all.
        """
        tap = for_first("ignore_cancels", times, lost)
        return tap_parts(action, tap, ("cancel", Side.REQUEST))

    @makes_fault
    def slow_server(
        self, action: ActionText, by: Seconds, *, lasting: Seconds | None = None
    ) -> Begin:
        """Have everything take so many seconds that an action server gets or sends.

        Args:
            by: Seconds, for each request, answer and feedback.
        """
        sides = [(part, side) for part in PARTS for side in (Side.REQUEST, Side.RESPONSE)]
        return tap_parts(action, later("slow_server", by), *sides, ("feedback", Side.MESSAGE))

    # ---- feedback ------------------------------------------------------------------------

    @makes_fault
    def silence_feedback(self, action: ActionText, *, lasting: Seconds | None = None) -> Begin:
        """Lose all feedback."""
        return _feedback(action, lost)

    @makes_fault
    def delay_feedback(
        self, action: ActionText, by: Seconds, *, lasting: Seconds | None = None
    ) -> Begin:
        """Deliver feedback late, after the end of its goal, too."""
        return _feedback(action, later("delay_feedback", by))

    @makes_fault
    def freeze_feedback(self, action: ActionText, *, lasting: Seconds | None = None) -> Begin:
        """Send stale feedback: each goal's first again and again, instead of what comes after."""

        def freeze(fault: FaultInstance, passing: Passing) -> Fates:
            goal = bytes(passing.message.goal_id.uuid)
            return (Delivery(deepcopy(fault.kept.setdefault(goal, passing.message))),)

        return _feedback(action, freeze)

    @makes_fault
    def forge_feedback(
        self, action: ActionText, *, instead: bool = False, lasting: Seconds | None = None
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
        action: ActionText,
        how: ReadyMadeName | Callable[[Any], Any] = "nan",
        *,
        field: str | None = None,
        lasting: Seconds | None = None,
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

    @makes_fault
    def set_feedback(
        self, /, action: ActionText, *, lasting: Seconds | None = None, **fields: Any
    ) -> Begin:
        """Give fields of the feedback other values.

        Args:
            fields: By their dotted names, such as ``remaining_angle=0.5``.
        """
        return _set_fields("feedback", Side.MESSAGE, action, fields)

    @makes_fault
    def set_result(
        self, /, action: ActionText, *, lasting: Seconds | None = None, **fields: Any
    ) -> Begin:
        """Give fields of the results other values; how a goal has ended stays as it is.

        Args:
            fields: By their dotted names, such as ``error_code=906``.
        """
        return _set_fields("result", Side.RESPONSE, action, fields)


def _set_fields(part: str, side: Side, action: str, fields: dict[str, Any]) -> Begin:
    """Set fields of one part of an action, its feedback or its result, in each message."""
    change = setting(f"set_{part}", fields)

    def tap(_: FaultInstance, passing: Passing) -> Fates:
        change(getattr(passing.message, part))
        return (Delivery(passing.message),)

    def begin(fault: FaultInstance) -> None:
        change(getattr(fault.action_type(action), part.capitalize())())  # refuses unknown fields
        fault.tap(part_of(fault, action, part), side, tap)

    return begin


def tap_parts(action: str, tap: Tap, *sides: tuple[str, Side]) -> Begin:
    """Give what taps an action, each part of it on a side."""

    def begin(fault: FaultInstance) -> None:
        for part, side in sides:
            fault.tap(part_of(fault, action, part), side, tap)

    return begin


def part_of(fault: FaultInstance, action: str, part: str) -> str:
    """Return the full name of a part of an action that is offered."""
    return f"{fault.action(action)}/_action/{ACTION_PARTS[part]}"


def _feedback(action: str, tap: Tap) -> Begin:
    return tap_parts(action, tap, ("feedback", Side.MESSAGE))
