"""Action servers that may give any answer: the clients that the attempts talk to."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from functools import partial
from typing import Any, TypeAlias

from py_trees.common import Status

from bt_mission.commands.prove.answers import ANSWERS, ROWS, SILENT, Answer, AnswerSet
from bt_mission.commands.prove.choices import NOTHING, Choices, Possibility
from bt_mission.commands.prove.values import Known, Message, ValueCases, more_words
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.behaviours.evaluator import Evaluator
from bt_mission.executive.goals.goal import Goal, GoalStatus, GoalTrigger, Phase
from bt_mission.ros.interface_types import action_type, fill

Question: TypeAlias = tuple[Possibility, ...]
"""What may happen next at one place: exactly one of these options is taken."""


class ServedGoal:
    """One goal as its server sees it."""

    def __init__(self, server: GoalServer, goal: Goal) -> None:
        self.server = server
        self.goal = goal
        self.leaf: ActionLeaf | None = None
        self.stage = "asked"
        """Then "working", or "mute"; "over" once the server has ended it or lost it."""
        self.is_cancel_open = False
        """Is there a cancel request without an answer?"""
        self.delays = 0
        """The ticks for which the present answer was not there yet, though something happened."""
        self.refuses = self.ignores = False
        """Does it refuse every cancel, or answer none?"""
        self.is_silent = False
        """Does it send no more feedback?"""
        self.feedback = ""

    @property
    def is_live(self) -> bool:
        """Does the server work on it?"""
        return self.stage == "working"

    @property
    def is_owed(self) -> bool:
        """Does its server owe an answer that it will give?"""
        return self.stage == "asked" or (self.stage == "working" and self.is_cancel_pending)

    @property
    def is_cancel_pending(self) -> bool:
        """Is there a cancel request that its server will answer?"""
        is_there = self.is_cancel_open and self.goal.accepted
        return is_there and not self.refuses and not self.ignores

    @property
    def is_read(self) -> bool:
        """Does the leaf that has sent it still take its feedback and result?"""
        leaf = self.leaf
        return (
            leaf is not None
            and leaf.status is Status.RUNNING
            and leaf.attempt is not None
            and leaf.attempt.goal is self.goal
        )

    def key(self, numbers: Mapping[int, int]) -> tuple[Any, ...]:
        """Return its state as the server sees it, its delays apart.

        Nobody cancels a goal again that the ledger has given up, so only its end matters.

        Args:
            numbers: Of the goals in the ledger, by their `id`.
        """
        goal = self.goal
        number = numbers.get(id(goal), -1)
        read = (self.is_silent, self.feedback) if self.is_read else ()
        if goal.phase is Phase.LOST and self.is_live and not self.is_cancel_pending:
            return goal.owner, number, *read
        flags = self.is_cancel_open, self.refuses, self.ignores
        return goal.owner, self.stage, *flags, number, *read


class GoalServer:
    """An action whose server may do anything; implements ``GoalClient``.

    Args:
        name: Of the action.
        type_name: Its type.
        choices: Decides.
        answers: Which are considered.
        cases: Values of results.
        evaluator_of: Returns what computes the values of a leaf.
        on_use: Called before a leaf asks for it, or sends a goal.
    """

    def __init__(
        self,
        name: str,
        type_name: str,
        choices: Choices,
        answers: AnswerSet,
        cases: ValueCases,
        evaluator_of: Callable[[ActionLeaf], Evaluator],
        on_use: Callable[[GoalServer], None],
    ) -> None:
        self.name, self.type_name = name, type_name
        self._type = action_type(type_name)
        self._choices, self._answers, self._cases = choices, answers, cases
        self._evaluator_of, self._on_use = evaluator_of, on_use
        self._requests, self._results_of, self._present = Known(), Known(), Known()
        self._words = Known({row.name: f"{name} {row.words}" for row in ROWS if row.words})
        self.goals: list[ServedGoal] = []
        """Those that the server has not ended, in the order in which they arrived."""
        self.is_away = False
        self.is_seen = False
        """Has the present tick looked for it? It sees the same each time."""
        self.is_untimed = False
        """May answers be late by any number of ticks?"""
        self.is_cut = Known()
        """Holds something if an answer might have been later than it was."""
        self.is_lost = False
        """Has it gone since the last tick? Its attempts notice that in the next one."""
        self.on_answer: Callable[[Goal, GoalTrigger | GoalStatus | None, Any], None] = _ignore
        """Called before a goal takes an answer: an event; the status and message of its result;
        or None and feedback."""

    # ---- what the attempts and the ledger call ----------------------------------------------

    def is_ready(self) -> bool:
        """Choose whether there is a server, unless it works on a goal."""
        self._on_use(self)
        if any(goal.stage != "over" for goal in self.answerable):
            return not self.is_away
        if self.is_lost:
            return False
        if self.is_seen:
            return not self.is_away
        self.is_seen = True
        rows, options = self._presence("missing" if self.is_away else "found")
        row = rows[self._choices.choose(options)]
        self.is_away = row.name in ("no_server", "away")
        return not self.is_away

    def obstacle(self) -> str:
        """There is never more than one server."""
        return ""

    def _presence(self, stage: str) -> tuple[list[Answer], Question]:
        known: tuple[list[Answer], Question] | None = self._present.get(stage)
        if known is None:
            rows = self._answers.at(stage, self.name)
            known = self._present[stage] = rows, tuple(map(self._option, rows))
        return known

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        """Return a goal with these fields. Raises FillError."""
        key = repr(fields)
        if key in self._requests:
            return self._requests[key]
        count = len(self._choices.trail)
        request = fill(self._type.Goal(), fields)
        if len(self._choices.trail) == count:  # no field is drawn
            self._requests[key] = request
        return request

    def send(self, goal: Goal, _request: Any) -> None:
        """Take a goal."""
        self._on_use(self)
        self.goals.append(ServedGoal(self, goal))

    def recover_goal(self, goal: Goal) -> None:
        """Not used: no mission that is proved is resumed."""
        raise NotImplementedError

    def ask_result(self, goal: Goal) -> None:
        """The result follows from :meth:`questions`."""

    def send_cancel(self, goal: Goal) -> None:
        """Note a cancel request."""
        for served in self.goals:
            if served.goal is goal:
                served.is_cancel_open, served.delays = True, 0

    # ---- what may happen --------------------------------------------------------------------

    def adopt(self, leaves: list[ActionLeaf]) -> None:
        """Note whose goals they are, after a tick; forget those that are over."""
        self.is_seen = False
        if not self.goals:
            return
        self.is_lost = False
        self.goals = [served for served in self.goals if served.stage != "over"]
        for served in self.goals:
            if served.leaf is None:
                served.leaf = next(
                    (leaf for leaf in leaves if leaf.attempt and leaf.attempt.goal is served.goal),
                    None,
                )

    def key(self, numbers: Mapping[int, int], names: Collection[str] | None) -> tuple[Any, ...]:
        """Return its state, and that of its goals that it may still answer.

        Args:
            numbers: Of the goals in the ledger, by their `id`.
            names: Of the servers for which a leaf may still ask; None for all.
        """
        is_away = self.is_away and (names is None or self.name in names)
        if not self.goals:
            return self.name, is_away
        return self.name, is_away, *(entry.key(numbers) for entry in self.answerable)

    @property
    def answerable(self) -> list[ServedGoal]:
        """The goals that may still get an answer."""
        is_late = bool(self._answers.at("mute", self.name))
        return [entry for entry in self.goals if is_late or entry.stage != "mute"]

    def beat(self) -> None:
        """Send the feedback that keeps a goal from its limit of silence."""
        for served in self.goals:
            if served.leaf is None or served.stage != "working" or served.is_silent:
                continue
            values = self._evaluator_of(served.leaf)
            if values.node.feedback_timeout is None or served.goal.phase is not Phase.ACTIVE:
                continue
            condition, fields = values.node.cancel_when, None
            if condition is not None:
                kind, use = self._type.Feedback, self._cases.condition_of(values.node)
                fields = self._cases.message_that(use, kind, values.scope.values, holds=False)
            self._feed(served, fields or {})

    def refuse_again(self) -> None:
        """Refuse the cancels of goals whose server refuses every cancel."""
        for served in self.goals:
            is_due = served.is_cancel_open and served.goal.accepted and served.stage == "working"
            if is_due and served.refuses:
                self.refuse_cancel(served)

    def questions(self) -> Iterator[Question]:
        """Yield what may happen at each goal."""
        for served in self.goals:
            question = self._question(served)
            if question is not None:
                yield question

    def _question(self, served: ServedGoal) -> Question | None:
        match served.stage:
            case "asked":
                return self._rows("asked", served, last=self._not_yet(served))
            case "mute":
                return self._rows("mute", served, NOTHING)
            case "working" if served.is_cancel_pending:
                return self._rows("cancel", served, last=self._not_yet(served))
            case "working":
                return self._rows("working", served, NOTHING)
        return None

    def _not_yet(self, served: ServedGoal) -> Possibility | None:
        """Return that an answer comes later; None where it has come late enough."""
        is_released = served.goal.orphaned_ns is not None
        if self.is_untimed or (is_released and self.may_be_given_up(served)):
            return NOTHING
        if served.delays < MOST_DELAYS:
            return NOTHING._replace(act=partial(self._delay, served))
        self.is_cut[MOST_DELAYS] = True
        return None

    def may_be_given_up(self, served: ServedGoal) -> bool:
        """May the ledger give it up before its server answers it in time?"""
        if served.stage != "asked" or served.leaf is None:
            return False
        node = self._evaluator_of(served.leaf).node
        is_shorter: bool = node.cancel_timeout < node.acceptance_timeout
        return is_shorter

    def _delay(self, served: ServedGoal) -> None:
        served.delays += 1

    def _rows(
        self, stage: str, served: ServedGoal, *first: Possibility, last: Possibility | None = None
    ) -> Question | None:
        options: list[Possibility] = []
        is_read = served.is_read
        for row in self._answers.at(stage, self.name):
            if is_read or row.name not in UNREAD:
                options += self._options(row, served)
        if last is not None and options:
            options.append(last)
        return (*first, *options) if options else None

    def _options(self, row: Answer, served: ServedGoal) -> Iterator[Possibility]:
        match row.name:
            case "silence":
                if served.leaf is not None and not served.is_silent:
                    node = self._evaluator_of(served.leaf).node
                    if node.feedback_timeout is not None:
                        yield self._option(row, partial(self.silence, served))
            case "condition":
                yield from self._feedback(row, served, holds=True)
            case "feedback":
                yield from self._feedback(row, served, holds=False)
            case (
                "succeed"
                | "abort"
                | "confirm_cancel"
                | "succeed_first"
                | "abort_first"
                | ("cancel_outside")
            ):
                status = _STATUSES[row.name]
                for fields, faults, _ in self._results(served):
                    act = partial(self._end, served, status, fields)
                    option = self._option(row, act, more_words(fields))
                    yield option._replace(faults=option.faults + faults)
            case _:
                yield self._option(row, partial(getattr(self, row.name), served))

    def _option(
        self, row: Answer, act: Callable[[], None] | None = None, more: str = ""
    ) -> Possibility:
        words = self._words.get(row.name, "")
        return Possibility(words + more if words else "", row.faults, act, row.name not in SILENT)

    # ---- the answers ------------------------------------------------------------------------

    def accept(self, served: ServedGoal) -> None:
        """Accept the goal."""
        served.stage, served.delays = "working", 0
        self._pass_event(served, GoalTrigger.ACCEPTED)

    late_accept = accept

    def reject(self, served: ServedGoal) -> None:
        """Reject it."""
        served.stage = "over"
        self._pass_event(served, GoalTrigger.REJECTED)

    def no_answer(self, served: ServedGoal) -> None:
        """Answer nothing."""
        served.stage, served.delays = "mute", 0

    def server_lost(self, _served: ServedGoal) -> None:
        """Leave the graph, with all goals."""
        self.is_away = self.is_lost = True
        for served in self.goals:
            served.stage = "over"

    def refuse_cancel(self, served: ServedGoal) -> None:
        """Refuse this cancel and every later one."""
        served.refuses, served.is_cancel_open, served.delays = True, False, 0
        self._pass_event(served, GoalTrigger.CANCEL_REFUSED)

    def ignore_cancel(self, served: ServedGoal) -> None:
        """Answer no cancel."""
        served.ignores, served.is_cancel_open, served.delays = True, False, 0

    def silence(self, served: ServedGoal) -> None:
        """Send no more feedback."""
        served.is_silent = True

    def _end(self, served: ServedGoal, status: GoalStatus, fields: Mapping[str, Any]) -> None:
        served.stage = "over"
        result = self._cases.message(self._type.Result, fields)
        self.on_answer(served.goal, status, result)
        served.goal.on_result(status, result)

    def _pass_event(self, served: ServedGoal, event: GoalTrigger) -> None:
        self.on_answer(served.goal, event, None)
        served.goal.on(event)

    def _feed(self, served: ServedGoal, fields: Mapping[str, Any]) -> None:
        feedback = self._cases.message(self._type.Feedback, fields)
        self.on_answer(served.goal, None, feedback)
        served.goal.on_feedback(feedback)

    def _results(self, served: ServedGoal) -> list[Message]:
        """Return the results that a mission can tell apart."""
        if not served.is_read:
            return [Message({})]
        if served.leaf not in self._results_of:
            outputs = self._evaluator_of(served.leaf).node.outputs if served.leaf else {}
            cases = self._cases.of_outputs(outputs, self._type.Result())
            cases = self._cases.considered(cases, self._answers, self.name)
            self._results_of[served.leaf] = cases
        collected: list[Message] = self._results_of[served.leaf]
        return collected

    def _feedback(self, row: Answer, served: ServedGoal, *, holds: bool) -> Iterator[Possibility]:
        leaf = served.leaf
        if leaf is None or leaf.attempt is None or leaf.attempt.goal is not served.goal:
            return
        attempt, values = leaf.attempt, self._evaluator_of(leaf)
        node, variables = values.node, values.scope.values
        if attempt.is_decided or attempt.cause is not None or served.goal.phase is not Phase.ACTIVE:
            return
        condition = node.cancel_when
        if holds and condition is None:
            return
        is_read = condition is not None and any(
            name.variable or name.name in variables for name in condition.references
        )
        if not holds and not is_read:
            return
        fields: Mapping[str, Any] | None = {}
        if condition is not None:
            use = self._cases.condition_of(node)
            fields = self._cases.message_that(use, self._type.Feedback, variables, holds=holds)
        if fields is None or (not holds and served.feedback == repr(fields)):
            return
        given = fields

        def feed() -> None:
            served.feedback = repr(given)
            self._feed(served, given)

        yield self._option(row, feed)


def _ignore(_goal: Goal, _answer: GoalTrigger | GoalStatus | None, _message: Any) -> None:
    """Note no answer."""


MOST_DELAYS = 2
"""Ticks with other events for which an answer may not be there yet."""

UNREAD = frozenset(("abort", "cancel_outside", "succeed_first", "abort_first", "silence"))
"""Answers without a further effect where no leaf takes them."""

_STATUSES = {
    "succeed": GoalStatus.SUCCEEDED,
    "succeed_first": GoalStatus.SUCCEEDED,
    "abort": GoalStatus.ABORTED,
    "abort_first": GoalStatus.ABORTED,
    "confirm_cancel": GoalStatus.CANCELED,
    "cancel_outside": GoalStatus.CANCELED,
}

assert set(_STATUSES) <= set(ANSWERS)
