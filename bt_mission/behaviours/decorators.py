"""Repeat and retry, with counts and pauses known only when they start; and a named tree's place."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.behaviours.control import ConditionResult, Rounds
from bt_mission.behaviours.hooks import HookedDecorator
from bt_mission.behaviours.runtime import Runtime, Scope
from bt_mission.core.stamps import NS
from bt_mission.language.expressions.values import NoValue


class Repeat(HookedDecorator):
    """Runs its child again and again, as long as that succeeds.

    Without a condition it succeeds after its count of rounds. With one it succeeds once the
    condition says so, and fails where its count of rounds is over before. Each round begins in a
    tick of its own, so that rounds which take no time keep no tick from its end.
    """

    def __init__(self, name: str, child: Behaviour, rounds: Rounds) -> None:
        super().__init__(name, child)
        self._rounds = rounds
        self._done = 0
        self._count: int | None = None
        self._is_within = False

    def save_state(self, _now_ns: int) -> dict[str, Any]:
        """The rounds done, how many there are, and whether one has begun."""
        return {"done": self._done, "count": self._count, "within": self._is_within}

    def restore_state(self, state: dict[str, Any], _now_ns: int) -> None:
        """Go on with the same round, or the next one."""
        self._done, self._count = state["done"], state["count"]
        self._is_within = state.get("within", True)

    def walk(self) -> Iterator[Behaviour]:
        """Read the count at entry; ask before each round."""
        rounds = self._rounds
        if self.status is not Status.RUNNING:
            self._done, self._is_within = 0, False
            self._count = None if rounds.count is None else rounds.count()
        if not self._is_within and rounds.before is not None:
            verdict = rounds.before()
            self.feedback_message = self._said(verdict, self._done)
            if not verdict.holds:
                if self._done == 0:
                    self.decorated.stop(Status.INVALID)
                self.stop(Status.SUCCESS)
                yield self
                return
        self._is_within = True
        yield from super().walk()

    def update(self) -> Status:
        """Count a success; say which round this is."""
        status = self.decorated.status
        if status is Status.SUCCESS:
            self._is_within = False
            self._done += 1
            return self._after_round()
        if not self._rounds.has_condition:
            self.feedback_message = self._which(self._done + 1)
        return status

    def _after_round(self) -> Status:
        rounds, is_over = self._rounds, self._done == self._count
        if not rounds.has_condition:
            self.feedback_message = self._which(self._done + (not is_over))
            return Status.SUCCESS if is_over else Status.RUNNING
        if rounds.after is not None:
            verdict = rounds.after()
            self.feedback_message = self._said(verdict, self._done)
            if verdict.holds:
                return Status.SUCCESS
        if not is_over:
            return Status.RUNNING
        if rounds.before is not None:
            verdict = rounds.before()
            self.feedback_message = self._said(verdict, self._done)
            if not verdict.holds:
                return Status.SUCCESS
        self.feedback_message = f"not ended by its condition: {self.feedback_message}"
        return Status.FAILURE

    def _which(self, number: int) -> str:
        return f"{number} of {self._count}"

    def _said(self, verdict: ConditionResult, done: int) -> str:
        most = "" if self._count is None else f" of at most {self._count}"
        return f"{done}{most} rounds done, condition {verdict.text}"


class Retry(HookedDecorator, py_trees.decorators.Retry):
    """Tries its child up to ``attempts`` times, with a pause of ROS time after a failure."""

    def __init__(
        self,
        name: str,
        child: Behaviour,
        attempts: Callable[[], int],
        pause_s: Callable[[], float],
    ) -> None:
        super().__init__(name=name, child=child, num_failures=1)
        self._attempts = attempts
        self._pause_s = pause_s
        self._resume_ns: int | None = None
        self._runtime: Runtime

    def setup(self, **kwargs: Any) -> None:
        """Take the runtime."""
        self._runtime = kwargs["runtime"]

    def initialise(self) -> None:
        """Read the number of attempts."""
        super().initialise()
        self._resume_ns = None
        self.num_failures = self._attempts()

    def save_state(self, now_ns: int) -> dict[str, Any]:
        """The failures so far, how many are allowed, and what is left of a pause."""
        left_ns = None if self._resume_ns is None else self._resume_ns - now_ns
        return {"failures": self.failures, "attempts": self.num_failures, "left_ns": left_ns}

    def restore_state(self, state: dict[str, Any], now_ns: int) -> None:
        """Go on with the pause, or the next attempt."""
        self.failures, self.num_failures = state["failures"], state["attempts"]
        left_ns = state["left_ns"]
        self._resume_ns = None if left_ns is None else now_ns + left_ns

    def walk(self) -> Iterator[Behaviour]:
        """Tick the child, unless a pause after a failure is on."""
        if self.status == Status.RUNNING and self._resume_ns is not None:
            if self._runtime.now_ns < self._resume_ns:
                yield self
                return
            self._resume_ns = None
        yield from super().walk()

    def update(self) -> Status:
        """Count a failure, and pause after it if another attempt is left."""
        failures = self.failures
        status = super().update()
        self.feedback_message = f"attempt {min(self.failures + 1, self.num_failures)}"
        self.feedback_message += f" of {self.num_failures}"
        if status == Status.RUNNING and self.failures > failures:
            pause_s = self._pause_s()
            self._resume_ns = self._runtime.now_ns + round(pause_s * NS)
            self.feedback_message += f", after a pause of {pause_s:g} s"
        return status


class Subtree(HookedDecorator):
    """Runs the tree below it with variables of its own, and ends as that does.

    Outputs go to the caller when the tree has ended, with success or failure, if they have a
    value; not when it is halted.

    Args:
        inputs: Gives the values that its variables begin with, at each entry.
        inner: The variables of the tree.
        outer: Those of its caller.
        outputs: Variable of the tree to variable of the caller.
    """

    def __init__(
        self,
        name: str,
        child: Behaviour,
        inputs: Callable[[], Mapping[str, Any]],
        inner: Scope,
        outer: Scope,
        outputs: Mapping[str, str],
    ) -> None:
        super().__init__(name, child)
        self._inputs = inputs
        self.inner = inner
        """The variables of the tree below."""
        self._outer = outer
        self._outputs = outputs

    def initialise(self) -> None:
        """Forget the last time, and take the inputs."""
        self.inner.replace(self._inputs())

    def update(self) -> Status:
        """End as the tree does."""
        self.feedback_message = ""
        return self.decorated.status

    def terminate(self, new_status: Status) -> None:
        """Hand the outputs out."""
        if new_status is not Status.INVALID:
            values = self.inner.values
            for name, ours in self._outputs.items():
                if name in values and not isinstance(values[name], NoValue):
                    self._outer.values[ours] = values[name]
