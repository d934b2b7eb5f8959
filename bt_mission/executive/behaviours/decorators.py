"""Decorators that repeat their child or change its result, and the node of a named tree."""

from __future__ import annotations

from typing import Any

import py_trees
from py_trees.common import Status

from bt_mission.base.diagnostics import describe
from bt_mission.base.stamps import NS
from bt_mission.executive.behaviours.evaluator import Condition, Evaluator
from bt_mission.executive.behaviours.hooks import HookedDecorator
from bt_mission.executive.behaviours.runtime import MissionFailure, Runtime
from bt_mission.language.expressions.values import WORDS, NoValue, fits, type_of
from bt_mission.language.nodes.decorators import RepeatSettings, RetryNode
from bt_mission.language.nodes.fields import SECONDS, TIMES
from bt_mission.language.nodes.subtree import TreeNode


class Repeat(HookedDecorator):
    """Runs its child repeatedly, as long as the child succeeds.

    Without a condition it succeeds after its count of rounds. With one it succeeds once the
    condition is true, and fails if its count of rounds is over before. Each round begins in a
    separate tick, so that a tick ends even if rounds take no time.
    """

    _done = 0
    _count: int | None = None
    _is_within = False

    @property
    def done(self) -> int:
        """The number of rounds done."""
        return self._done

    @property
    def count(self) -> int | None:
        """The most rounds; None for no bound."""
        return self._count

    def save_state(self, _now_ns: int) -> dict[str, Any]:
        """Return the rounds done, their number, and whether a round has begun."""
        return {"done": self._done, "count": self._count, "within": self._is_within}

    def restore_state(self, state: dict[str, Any], _now_ns: int) -> None:
        """Continue with the same round, or the next one."""
        self._done, self._count = state["done"], state["count"]
        self._is_within = state.get("within", True)

    def read_again(self) -> None:
        """Take the count of a new version of the node; the rounds so far count."""
        count = self._node.settings.count
        self._count = None if count is None else int(self._values.number(count, TIMES))

    def enter(self) -> Status | None:
        """Evaluate the count at entry, and the condition before each round."""
        if self._is_within and self.status is Status.RUNNING:
            return None
        settings: RepeatSettings = self._node.settings
        if self.status is not Status.RUNNING:
            self._done, self._is_within, count = 0, False, settings.count
            self._count = None if count is None else int(self._values.number(count, TIMES))
        if settings.before is not None and not self._holds(settings.before):
            if self._done == 0:
                self.decorated.stop(Status.INVALID)
            return Status.SUCCESS
        self._is_within = True
        self._say_round()
        return super().enter()

    def _say_round(self) -> None:
        if not self._node.settings.has_condition:
            self.feedback_message = self._which(self._done + 1)

    def update(self) -> Status:
        """Count a success; report the number of the round."""
        status = self.decorated.status
        if status is Status.SUCCESS:
            self._is_within = False
            self._done += 1
            return self._after_round()
        if not self.feedback_message:  # it was restored within a round
            self._say_round()
        return status

    def _after_round(self) -> Status:
        settings: RepeatSettings = self._node.settings
        is_over = self._count is not None and self._done >= self._count
        if not settings.has_condition:
            self.feedback_message = self._which(self._done + (not is_over))
            return Status.SUCCESS if is_over else Status.RUNNING
        if settings.after is not None and self._holds(settings.after):
            return Status.SUCCESS
        if not is_over:
            return Status.RUNNING
        if settings.before is not None and not self._holds(settings.before):
            return Status.SUCCESS
        self.feedback_message = f"not ended by its condition: {self.feedback_message}"
        return Status.FAILURE

    def _holds(self, condition: Condition) -> bool:
        """Evaluate a condition, and put it into the message."""
        result = self._values.ask(condition)
        most = "" if self._count is None else f" of at most {self._count}"
        self.feedback_message = f"{self._done}{most} rounds done, condition {result.text}"
        return result.holds

    def _which(self, number: int) -> str:
        return f"{number} of {self._count}"


class Inverter(HookedDecorator, py_trees.decorators.Inverter):
    """The inverter of py_trees."""


class Force(HookedDecorator):
    """Ends as the node says, regardless of its child's result."""

    def update(self) -> Status:
        """Replace the result, and report the replacement."""
        forced, status = Status[self._node.status.upper()], self.decorated.status
        self.feedback_message = self.decorated.feedback_message
        if status in (Status.RUNNING, forced):
            return status
        reason = f" [{self.feedback_message}]" if self.feedback_message else ""
        self.feedback_message = f"{status.name.lower()} is {forced.name.lower()}{reason}"
        return forced


class Retry(HookedDecorator, py_trees.decorators.Retry):
    """Tries its child up to ``attempts`` times, with a pause of ROS time after a failure."""

    _resume_ns: int | None = None
    _runtime: Runtime

    def __init__(self, node: RetryNode, values: Evaluator) -> None:
        super().__init__(node, values, num_failures=1)

    def setup(self, **kwargs: Any) -> None:
        """Take the runtime."""
        self._runtime = kwargs["runtime"]

    def initialise(self) -> None:
        """Read the number of attempts."""
        super().initialise()
        self._resume_ns = None
        self.num_failures = int(self._values.number(self._node.settings.attempts, TIMES))

    def save_state(self, now_ns: int) -> dict[str, Any]:
        """Return the failures so far, the number allowed, and the remaining time of a pause."""
        left_ns = None if self._resume_ns is None else self._resume_ns - now_ns
        return {"failures": self.failures, "attempts": self.num_failures, "left_ns": left_ns}

    def restore_state(self, state: dict[str, Any], now_ns: int) -> None:
        """Continue with the pause, or the next attempt."""
        self.failures, self.num_failures = state["failures"], state["attempts"]
        left_ns = state["left_ns"]
        self._resume_ns = None if left_ns is None else now_ns + left_ns

    def read_again(self) -> None:
        """Take the attempts of a new version of the node; the failures so far count."""
        self.num_failures = int(self._values.number(self._node.settings.attempts, TIMES))

    @property
    def due_ns(self) -> int | None:
        """The end of a pause after a failure; None without one."""
        return self._resume_ns

    def enter(self) -> Status | None:
        """Tick the child, unless a pause after a failure is on."""
        if self.status is Status.RUNNING and self._resume_ns is not None:
            if self._runtime.now_ns < self._resume_ns:
                return Status.RUNNING
            self._resume_ns = None
        return super().enter()

    def update(self) -> Status:
        """Count a failure, and pause after it if another attempt remains."""
        failures = self.failures
        status = super().update()
        self.feedback_message = f"attempt {min(self.failures + 1, self.num_failures)}"
        self.feedback_message += f" of {self.num_failures}"
        if status == Status.RUNNING and self.failures > failures:
            pause_s = self._values.number(self._node.settings.pause, SECONDS)
            self._resume_ns = self._runtime.now_ns + round(pause_s * NS)
            self.feedback_message += f", after a pause of {pause_s:g} s"
        return status


class Subtree(HookedDecorator):
    """Runs its tree with a separate scope of variables, and ends as the tree does.

    An input that names a variable of the caller has the value of that variable at each tick, and a
    variable of the caller has that of its output after each tick: nothing else runs in between.
    """

    def __init__(self, node: TreeNode, values: Evaluator) -> None:
        super().__init__(node, values)
        self.inner = values.inner
        """The variables of the tree below."""
        topics = {follow.variable for follow in values.inner.followed}
        self._written = {
            name: variable for name, variable in node.outputs.items() if name not in topics
        }

    def initialise(self) -> None:
        """Forget the last time, and take the inputs. Raises MissionFailure."""
        node, values = self._node, self._values
        given: dict[str, Any] = values.resolve(node.inputs)
        for name, value in given.items():
            if why := self._misfit(name, value):
                raise values.failure(why)
        self.inner.replace({**values.mission.trees[node.tree].inputs, **given})

    def enter(self) -> Status | None:
        """Take the present values of the caller's variables. Raises MissionFailure."""
        status = super().enter()
        self.take_inputs()
        outer, inner = self._values.scope.values, self.inner.values
        for name, variable in self._written.items():
            if variable in outer:
                inner[name] = outer[variable]
        return status

    def take_inputs(self) -> None:
        """Take the present values of inputs that are variables of the caller.

        Raises:
            MissionFailure: One has another type now.
        """
        outer, inner = self._values.scope.values, self.inner.values
        for name, variable in self._node.live_inputs.items():
            if variable in outer and outer[variable] is not inner.get(name):
                if why := self._misfit(name, outer[variable]):
                    raise MissionFailure(
                        f"{self._values.place}: '{self.name}' cannot continue: {why}"
                    )
                inner[name] = outer[variable]

    def update(self) -> Status:
        """Hand the outputs out, and end as the tree does."""
        self.feedback_message = ""
        outer, inner = self._values.scope.values, self.inner.values
        for name, variable in self._node.outputs.items():
            if name in inner and not isinstance(inner[name], NoValue):
                outer[variable] = inner[name]
        return self.decorated.status

    def _misfit(self, name: str, value: Any) -> str:
        """Return why a value does not fit an input; empty if it does."""
        wanted = self._node.takes.get(name)
        if wanted is None or isinstance(value, NoValue) or fits(type_of(value), wanted):
            return ""
        return f"'{name}': expected {WORDS[wanted]}, got {describe(value)}"
