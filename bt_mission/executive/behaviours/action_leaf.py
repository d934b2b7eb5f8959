"""The leaf that sends a goal of an action."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Selector, Sequence

from bt_mission.base.dds.liveliness import EXECUTIVE_LOST
from bt_mission.executive.behaviours.cleanup import Finally
from bt_mission.executive.behaviours.client_leaves import ClientLeaf
from bt_mission.executive.behaviours.control import Guard, Timeout
from bt_mission.executive.behaviours.evaluator import Evaluator
from bt_mission.executive.behaviours.leaves import LeafProgress
from bt_mission.executive.behaviours.runtime import read_field, scalars
from bt_mission.executive.goals.attempt import Attempt, AttemptResult, CancelCause, Limits
from bt_mission.executive.goals.goal import Goal, GoalClient
from bt_mission.executive.goals.progress_bounds import ProgressBounds
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.outcome import Outcome

HALTED = "halted"
"""The message of a leaf whose goal the tree has halted."""

_STOPPED = (Outcome.CANCELED_BY_CONDITION, Outcome.SUCCEEDED_LATE)
"""Outcomes after which `on_cancel` decides, if the condition was met."""


class ActionLeaf(ClientLeaf):
    """Sends one goal each time it starts, and turns the goal's outcome into a status.

    Succeeds when the goal does, unless it was to be canceled. If its condition was met, `on_cancel`
    is the status of a goal that is canceled or succeeds nevertheless. Outputs are written whenever
    the server sent a result, also of a goal that was canceled or aborted.
    """

    _client: GoalClient
    _message = ""
    _seen: tuple[str, Any] | None = None
    """Stage and newest feedback of the attempt in the last tick, until they are formatted."""

    def __init__(self, node: GoalNode, values: Evaluator) -> None:
        super().__init__(node, values)
        self.attempt: Attempt | None = None
        self._target: tuple[str, float] | None = None
        self._progress_bounds: ProgressBounds | None = None
        self._limits = Limits()
        self._started_ns = 0

    @property
    def feedback_message(self) -> str:
        """The result of the last tick as text. It is formatted when it is read."""
        if self._seen is not None:
            self._message, self._seen = _doing(*self._seen), None
        return self._message

    @feedback_message.setter
    def feedback_message(self, message: str) -> None:
        self._message, self._seen = message, None

    def _connected(self, name: str, type_name: str) -> GoalClient:
        return self._runtime.goal_client(name, type_name)

    def initialise(self) -> None:
        """Open a new attempt for this goal.

        Raises:
            MissionFailure: The goal's values do not fit its type.
        """
        self.attempt = None
        node = self._node
        with self._values.starting():
            request = self._client.prepare(self._values.resolve(node.sent))
        self._limits = self._bounds()
        self._target = self._values.target(node.cancel_when)
        self._progress_bounds = None
        self._started_ns = self._runtime.now_ns
        self.attempt = Attempt(
            self._client,
            self._runtime.ledger,
            self.name,
            request,
            self._limits,
            self._started_ns,
            node.moved_parts,
            self._halted_goals,
        )

    def _bounds(self) -> Limits:
        node, values = self._node, self._values
        given = (node.server_timeout, node.acceptance_timeout, node.cancel_timeout)
        server, answer, cancel = (limit for limit in given if limit is not None)
        asked = node.cancel_when
        return Limits(
            server=server,
            answer=answer,
            goal=values.limit(node.timeout),
            silence=values.limit(node.feedback_timeout),
            cancel=cancel,
            condition=None if asked is None else values.condition("cancel_when", asked),
            variables=None if asked is None else values.watched("cancel_when", asked),
        )

    def update(self) -> Status:
        """Poll the attempt. Write outputs and the reason when it has ended."""
        assert self.attempt is not None
        now_ns = self._runtime.now_ns
        if self.attempt.is_quiet(now_ns):
            return Status.RUNNING
        ending = self.attempt.poll(now_ns)
        if ending is None:
            self._seen = self.attempt.stage, self.attempt.feedback
            return Status.RUNNING
        self.feedback_message = _say(ending)
        if ending.result is not None:
            self._values.store(self._node.outputs, ending.result)
        if ending.outcome is Outcome.SUCCEEDED:
            return Status.SUCCESS
        if self.attempt.cause is CancelCause.CONDITION and ending.outcome in _STOPPED:
            return Status.SUCCESS if self._node.on_cancel == "success" else Status.FAILURE
        return Status.FAILURE

    def _halted_goals(self) -> Iterator[Goal]:
        """Yield the goals that a sequence or fallback without memory halts in this tick.

        It does so once this leaf runs, since its later children ran so far.
        """
        node: Behaviour = self
        while (above := node.parent) is not None:
            if isinstance(above, Sequence | Selector) and not above.memory:
                for later in above.children[above.children.index(node) + 1 :]:
                    if later.status is Status.RUNNING:
                        yield from _goals_below(later)
            node = above

    @property
    def was_cut_off(self) -> bool:
        """Whether its last goal was aborted because the server took this process for dead."""
        ending = self.attempt.ending if self.attempt else None
        return (
            ending is not None
            and ending.outcome is Outcome.ABORTED
            and getattr(ending.result, "error_code", 0) == EXECUTIVE_LOST
        )

    @property
    def has_outcome(self) -> bool:
        """Whether the outcome of its goal is known, even if no tick has read it yet."""
        return self.attempt is not None and self.attempt.is_decided

    def supervise(self) -> None:
        """Enforce the limits of a goal that was sent, while the tree is not ticked.

        The next tick reads the outcome.
        """
        attempt, now_ns = self.attempt, self._runtime.now_ns
        if attempt is None or attempt.goal is None or attempt.ending is not None:
            return
        why = next(filter(None, (node.why_over() for node in self._bounds_around())), "")
        ending = attempt.poll(now_ns)
        if ending is None and why:
            attempt.halt(now_ns, why)
            ending = attempt.ending
        if ending is None:
            self._seen = attempt.stage, attempt.feedback
        else:
            self.feedback_message = _say(ending)

    def _bounds_around(self) -> Iterator[Guard | Timeout | Finally]:
        node: Behaviour | None = self.parent
        while node is not None:
            if isinstance(node, Guard | Timeout | Finally):
                yield node
            if isinstance(node, Finally) and node.is_detached:
                return  # what is above has halted it already
            node = node.parent

    def terminate(self, new_status: Status) -> None:
        """Hand a goal still under way to the ledger when the tree halts this leaf."""
        if new_status == Status.INVALID and self.attempt and self.attempt.ending is None:
            self.attempt.halt(self._runtime.now_ns)
            self.feedback_message = HALTED

    def save_state(self, _now_ns: int) -> dict[str, Any]:
        """The goal that it waits for."""
        goal = self.attempt.goal if self.attempt else None
        return {} if goal is None else {"goal": goal.id.hex()}

    def restore_state(self, _state: dict[str, Any], _now_ns: int) -> None:
        """Start again. :meth:`adopt` gives it the result of its goal first."""
        self.status = Status.INVALID

    def adopt(self, goal: Goal) -> None:
        """Take a goal that has ended as the goal that this leaf sent."""
        now_ns = self._runtime.now_ns
        self.attempt = Attempt.of(goal, self._runtime.ledger, now_ns)
        self._limits, self._target, self._started_ns = Limits(), None, now_ns
        self.status = Status.RUNNING

    @property
    def was_halted(self) -> bool:
        """Whether the tree halted its last goal before it ended."""
        ending = self.attempt.ending if self.attempt else None
        return ending is not None and ending.outcome is Outcome.CANCELED_BY_HALT

    @property
    def progress(self) -> LeafProgress | None:
        """The progress to the condition's bound, else by the goal's measure, else to the timeout.

        The goal's measure is what :class:`ProgressBounds` finds, such as the angle turned.
        """
        if self.status is not Status.RUNNING or self.attempt is None:
            return None
        feedback = self.attempt.feedback
        if self._target and feedback is not None:
            label, limit = self._target
            value = float(read_field(feedback, label))
            return LeafProgress(label, value, limit) if math.isfinite(value) else None
        if feedback is not None and (goal := self.attempt.goal) is not None:
            if self._progress_bounds is None:
                self._progress_bounds = ProgressBounds(scalars(goal.request))
            measure = self._progress_bounds.measure(scalars(feedback))
            if measure is not None:
                return LeafProgress(*measure)
        if self._limits.goal is not None:
            elapsed_s = (self._runtime.now_ns - self._started_ns) / 1e9
            return LeafProgress("s", elapsed_s, self._limits.goal)
        return None


def _goals_below(node: Behaviour) -> Iterator[Goal]:
    """Yield the goals of the leaves below a node that are under way."""
    for leaf in node.iterate():
        if isinstance(leaf, ActionLeaf) and leaf.status is Status.RUNNING:
            goal = leaf.attempt.goal if leaf.attempt else None
            if goal is not None:
                yield goal


def _doing(stage: str, feedback: Any) -> str:
    values = scalars(feedback)
    if not values or stage != "active":
        return stage
    return ", ".join(
        f"{name} {value:.2f}" if isinstance(value, float) else f"{name} {value}"
        for name, value in values.items()
    )


def _say(ending: AttemptResult) -> str:
    if ending.outcome is Outcome.SUCCEEDED:
        return ""
    return f"{ending.outcome}: {ending.reason}"
