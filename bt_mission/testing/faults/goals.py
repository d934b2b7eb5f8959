"""Faults of action servers: what becomes of goals, cancels, answers and results on their way.

They are the same for servers of ours, for those that a test plays, and for any other: what passes
between a server and its client is caught.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import TYPE_CHECKING, Any

from action_msgs.srv import CancelGoal

from bt_mission.testing.errors import ScenarioError
from bt_mission.testing.faults.fault import Fates, Fault, FaultInstance, Maker, nanoseconds, passed
from bt_mission.virtual_time import ACTION_PARTS, Answer, Delivery, Gate, Passing, Side

if TYPE_CHECKING:
    from bt_mission.goals.goal import Goal

PARTS = ("goal", "cancel", "result")
"""The services of an action."""


class GoalFaults(Maker):
    """Faults between an action server and its clients.

    Arguments that they share: ``action``, its name, or a short name of the mission language;
    ``goals``, how many are concerned (None is all), after which the fault ends; ``lasting``, for
    how many seconds. An action that nobody offers is a ScenarioError when the fault begins.
    """

    def reject_goals(
        self, action: str, goals: int | None = None, *, lasting: float | None = None
    ) -> Fault:
        """Reject the next goals."""
        _check_count("reject_goals", goals)

        def begin(fault: FaultInstance) -> None:
            response = fault.action_type(action).Impl.SendGoalService.Response
            reject = _counted(fault, goals, lambda _: (Answer(response(accepted=False)),))
            fault.tap(part_of(fault, action, "goal"), Side.REQUEST, reject)

        return self._fault("reject_goals", begin, lasting, action=action, goals=goals)

    def ignore_goals(
        self, action: str, goals: int | None = None, *, lasting: float | None = None
    ) -> Fault:
        """Lose goals before the server hears of them: it never answers, and does nothing."""
        _check_count("ignore_goals", goals)

        def begin(fault: FaultInstance) -> None:
            ignore = _counted(fault, goals, lambda _: ())
            fault.tap(part_of(fault, action, "goal"), Side.REQUEST, ignore)

        return self._fault("ignore_goals", begin, lasting, action=action, goals=goals)

    def drop_answers(
        self, action: str, goals: int | None = None, *, lasting: float | None = None
    ) -> Fault:
        """Lose the answers to goals: the server carries them out, and nobody knows of it."""
        _check_count("drop_answers", goals)

        def begin(fault: FaultInstance) -> None:
            drop = _counted(fault, goals, lambda _: ())
            fault.tap(part_of(fault, action, "goal"), Side.RESPONSE, drop)

        return self._fault("drop_answers", begin, lasting, action=action, goals=goals)

    def delay_answers(
        self, action: str, by: float, goals: int | None = None, *, lasting: float | None = None
    ) -> Fault:
        """Deliver the answers to goals late; meanwhile the server carries them out."""
        _check_count("delay_answers", goals)
        late = _later(nanoseconds("delay_answers", by))

        def begin(fault: FaultInstance) -> None:
            fault.tap(part_of(fault, action, "goal"), Side.RESPONSE, _counted(fault, goals, late))

        return self._fault("delay_answers", begin, lasting, action=action, by=by, goals=goals)

    def answer_after_halt(
        self,
        action: str,
        *,
        after: float = 0.0,
        at_most: float | None = None,
        lasting: float | None = None,
    ) -> Fault:
        """Hold the answer to a goal back until the client no longer wants the goal.

        :param after: seconds from there to the answer.
        :param at_most: so many seconds, where the client goes on wanting it.
        """
        after_ns = nanoseconds("after", after)
        most_ns = None if at_most is None else nanoseconds("at_most", at_most)

        def begin(fault: FaultInstance) -> None:
            name = fault.action(action)
            clock = fault.run.stage.clock
            gates: list[Gate] = []

            def hold(passing: Passing) -> Fates:
                gates.append(gate := Gate())
                if most_ns is not None:
                    gate.open(passing.time_ns + most_ns)
                return (Delivery(passing.message, gate=gate),)

            def on_goal(what: str, goal: Goal) -> None:
                if what == "handed over" and goal.goal_client.name == name:
                    release(after_ns)

            def release(by_ns: int) -> None:
                for gate in gates:
                    gate.open(clock.now_ns + by_ns)

            listeners = fault.run.stage.executive.goal_listeners
            listeners.append(on_goal)
            fault.undo(lambda: listeners.remove(on_goal))
            fault.undo(lambda: release(0))
            fault.tap(part_of(fault, action, "goal"), Side.RESPONSE, hold)

        return self._fault(
            "answer_after_halt",
            begin,
            lasting,
            action=action,
            after=after or None,
            at_most=at_most,
        )

    def repeat_answers(
        self,
        action: str,
        part: str = "goal",
        *,
        times: int = 2,
        after: float = 0.0,
        lasting: float | None = None,
    ) -> Fault:
        """Answer more than once.

        :param part: of the action: ``goal``, ``cancel`` or ``result``.
        :param after: seconds from each answer to the next.
        """
        _check_part("repeat_answers", part)
        if times < 2:
            raise ScenarioError(f"repeat_answers: expected 2 times or more, got {times!r}")
        after_ns = nanoseconds("after", after)

        def repeat(passing: Passing) -> Fates:
            return [
                Delivery(deepcopy(passing.message), after_ns=number * after_ns)
                for number in range(times)
            ]

        def begin(fault: FaultInstance) -> None:
            fault.tap(part_of(fault, action, part), Side.RESPONSE, repeat)

        return self._fault(
            "repeat_answers",
            begin,
            lasting,
            action=action,
            part=part,
            times=times,
            after=after or None,
        )

    def delay_results(
        self, action: str, by: float, goals: int | None = None, *, lasting: float | None = None
    ) -> Fault:
        """Deliver results late: the server has ended the goal, the client waits."""
        _check_count("delay_results", goals)
        late = _later(nanoseconds("delay_results", by))

        def begin(fault: FaultInstance) -> None:
            fault.tap(part_of(fault, action, "result"), Side.RESPONSE, _counted(fault, goals, late))

        return self._fault("delay_results", begin, lasting, action=action, by=by, goals=goals)

    def drop_results(
        self, action: str, goals: int | None = None, *, lasting: float | None = None
    ) -> Fault:
        """Lose results for ever."""
        _check_count("drop_results", goals)

        def begin(fault: FaultInstance) -> None:
            drop = _counted(fault, goals, lambda _: ())
            fault.tap(part_of(fault, action, "result"), Side.RESPONSE, drop)

        return self._fault("drop_results", begin, lasting, action=action, goals=goals)

    def refuse_cancels(
        self, action: str, times: int | None = None, *, lasting: float | None = None
    ) -> Fault:
        """Refuse requests to cancel; the server does not hear of them.

        :param times: so often; None is always.
        """
        _check_count("refuse_cancels", times)
        refusal = CancelGoal.Response(return_code=CancelGoal.Response.ERROR_REJECTED)

        def begin(fault: FaultInstance) -> None:
            refuse = _counted(fault, times, lambda _: (Answer(refusal),))
            fault.tap(part_of(fault, action, "cancel"), Side.REQUEST, refuse)

        return self._fault("refuse_cancels", begin, lasting, action=action, times=times)

    def ignore_cancels(
        self, action: str, times: int | None = None, *, lasting: float | None = None
    ) -> Fault:
        """Lose requests to cancel: the server goes on, and does not answer.

        :param times: so many; None is all.
        """
        _check_count("ignore_cancels", times)

        def begin(fault: FaultInstance) -> None:
            ignore = _counted(fault, times, lambda _: ())
            fault.tap(part_of(fault, action, "cancel"), Side.REQUEST, ignore)

        return self._fault("ignore_cancels", begin, lasting, action=action, times=times)

    def slow_server(self, action: str, by: float, *, lasting: float | None = None) -> Fault:
        """Have everything take so many seconds that an action server gets or sends.

        :param by: seconds, for each request, answer and feedback.
        """
        late = _later(nanoseconds("slow_server", by))

        def begin(fault: FaultInstance) -> None:
            for part in PARTS:
                fault.tap(part_of(fault, action, part), Side.REQUEST, late)
                fault.tap(part_of(fault, action, part), Side.RESPONSE, late)
            fault.tap(part_of(fault, action, "feedback"), Side.MESSAGE, late)

        return self._fault("slow_server", begin, lasting, action=action, by=by)


def part_of(fault: FaultInstance, action: str, part: str) -> str:
    """The full name of a part of an action that is offered."""
    return f"{fault.action(action)}/_action/{ACTION_PARTS[part]}"


def _counted(
    fault: FaultInstance, count: int | None, tap: Callable[[Passing], Fates]
) -> Callable[[Passing], Fates]:
    """A tap for so many things that pass, after which its fault ends."""
    if count is None:
        return tap
    left = [count]

    def counted(passing: Passing) -> Fates:
        left[0] -= 1
        if left[0] < 0:
            return passed(passing)
        if left[0] == 0:
            fault.end()
        return tap(passing)

    return counted


def _later(by_ns: int) -> Callable[[Passing], Fates]:
    return lambda passing: (Delivery(passing.message, after_ns=by_ns),)


def _check_count(what: str, count: Any) -> None:
    if count is not None and (not isinstance(count, int) or count < 1):
        raise ScenarioError(f"{what}: expected a whole number from 1 up, got {count!r}")


def _check_part(what: str, part: str) -> None:
    if part not in PARTS:
        raise ScenarioError(f"{what}: expected a part of {', '.join(PARTS)}, got '{part}'")
