"""The leaf that sees one goal of an action through."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from py_trees.common import Status

from bt_mission.behaviours.leaf import Leaf
from bt_mission.behaviours.progress import LeafProgress
from bt_mission.behaviours.runtime import (
    MissionFailure,
    Runtime,
    Scope,
    placed,
    read_field,
    scalars,
)
from bt_mission.core.errors import BtMissionError
from bt_mission.goals.attempt import Attempt, Limits
from bt_mission.goals.goal import Goal, GoalClient
from bt_mission.goals.outcome import AttemptResult, Outcome


@dataclass(frozen=True)
class Plan:
    """Everything an attempt needs that is known only when the leaf starts.

    :param goal: fields of the goal.
    :param limits: see :class:`bt_mission.goals.attempt.Limits`.
    :param target: the feedback field that the condition waits for, and its bound, where the
        condition is as simple as that.
    """

    goal: Mapping[str, Any]
    limits: Limits
    target: tuple[str, float] | None = None


class ActionLeaf(Leaf):
    """Sends one goal each time it starts, and turns the goal's outcome into a status.

    Succeeds when the goal does, or when it is cancelled by its condition and ``on_cancel`` is
    success. Outputs are written whenever the server sent a result, also a cancelled or aborted
    one.

    :param action: name of the action, such as ``/turn``.
    :param type_name: its type, such as ``bt_mission_interfaces/action/Turn``.
    :param plan: called at each start.
    :param on_cancel: status when the condition cancels the goal.
    :param outputs: result field to variable.
    :param scope: holds the variables that outputs go to.
    :param place: ``file:line:column`` of the step.
    """

    def __init__(
        self,
        name: str,
        action: str,
        type_name: str,
        plan: Callable[[], Plan],
        on_cancel: Status,
        outputs: Mapping[str, str],
        scope: Scope,
        place: str,
    ) -> None:
        super().__init__(name)
        self.action = action
        self.type_name = type_name
        self._plan = plan
        self._on_cancel = on_cancel
        self._outputs = outputs
        self._scope = scope
        self._place = place
        self.attempt: Attempt | None = None
        self._target: tuple[str, float] | None = None
        self._limits = Limits()
        self._started_ns = 0
        self._runtime: Runtime
        self._courier: GoalClient

    def setup(self, **kwargs: Any) -> None:
        """Take the runtime and make the client of the action."""
        self._runtime = kwargs["runtime"]
        with placed(self._place):
            self._courier = self._runtime.goal_client(self.action, self.type_name)

    def initialise(self) -> None:
        """Open an attempt of its own for this goal.

        :raises MissionFailure: when the goal's values do not fit its type.
        """
        plan = self._plan()
        try:
            request = self._courier.prepare(plan.goal)
        except BtMissionError as error:
            raise MissionFailure(f"{self._place}: '{self.name}' cannot start: {error}") from error
        self._target, self._limits = plan.target, plan.limits
        self._started_ns = self._runtime.now_ns
        self.attempt = Attempt(
            self._courier,
            self._runtime.ledger,
            self.name,
            request,
            plan.limits,
            self._started_ns,
        )

    def update(self) -> Status:
        """Poll the attempt; write outputs and say why when it has ended."""
        assert self.attempt is not None
        now_ns = self._runtime.now_ns
        if self.attempt.is_quiet(now_ns):
            return Status.RUNNING
        ending = self.attempt.poll(now_ns)
        if ending is None:
            self.feedback_message = self._doing(self.attempt)
            return Status.RUNNING
        self.feedback_message = _say(ending)
        if ending.result is not None:
            for field, variable in self._outputs.items():
                self._scope.values[variable] = read_field(ending.result, field)
        if ending.outcome is Outcome.SUCCEEDED:
            return Status.SUCCESS
        if ending.outcome is Outcome.CANCELED_BY_CONDITION:
            return self._on_cancel
        return Status.FAILURE

    def terminate(self, new_status: Status) -> None:
        """Hand a goal still under way to the ledger when the tree halts this leaf."""
        if new_status == Status.INVALID and self.attempt and self.attempt.ending is None:
            self.attempt.halt(self._runtime.now_ns)
            self.feedback_message = "halted"

    def save_state(self, _now_ns: int) -> dict[str, Any]:
        """The goal that it waits for."""
        goal = self.attempt.goal if self.attempt else None
        return {} if goal is None else {"goal": goal.id.hex()}

    def restore_state(self, _state: dict[str, Any], _now_ns: int) -> None:
        """Start anew: what has become of the goal shows first (:meth:`adopt`)."""
        self.status = Status.INVALID

    def adopt(self, goal: Goal) -> None:
        """Take a goal that has ended for the one that this leaf had sent."""
        now_ns = self._runtime.now_ns
        self.attempt = Attempt.of(goal, self._runtime.ledger, now_ns)
        self._limits, self._target, self._started_ns = Limits(), None, now_ns
        self.status = Status.RUNNING

    @property
    def was_halted(self) -> bool:
        """Was its last goal halted by the tree before it ended?"""
        ending = self.attempt.ending if self.attempt else None
        return ending is not None and ending.outcome is Outcome.CANCELED_BY_HALT

    @property
    def progress(self) -> LeafProgress | None:
        """Towards the bound of the condition, else towards the timeout; None without either."""
        if self.status is not Status.RUNNING or self.attempt is None:
            return None
        feedback = self.attempt.feedback
        if self._target and feedback is not None:
            label, limit = self._target
            value = float(read_field(feedback, label))
            return LeafProgress(label, value, limit) if math.isfinite(value) else None
        if self._limits.goal is not None:
            elapsed_s = (self._runtime.now_ns - self._started_ns) / 1e9
            return LeafProgress("s", elapsed_s, self._limits.goal)
        return None

    def _doing(self, attempt: Attempt) -> str:
        values = scalars(attempt.feedback)
        if not values or attempt.stage != "active":
            return attempt.stage
        return ", ".join(
            f"{name} {value:.2f}" if isinstance(value, float) else f"{name} {value}"
            for name, value in values.items()
        )


def _say(ending: AttemptResult) -> str:
    if ending.outcome is Outcome.SUCCEEDED:
        return ""
    return f"{ending.outcome}: {ending.reason}"
