"""Repeat and retry, with counts and pauses known only when they start; and a named tree's place."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.behaviours.hooks import HookedDecorator
from bt_mission.behaviours.runtime import Runtime, Scope
from bt_mission.core.stamps import NS


class Repeat(HookedDecorator, py_trees.decorators.Repeat):
    """Succeeds after its child has succeeded ``count`` times; fails as soon as the child fails."""

    def __init__(self, name: str, child: Behaviour, count: Callable[[], int]) -> None:
        super().__init__(name=name, child=child, num_success=1)
        self._count = count

    def initialise(self) -> None:
        """Read the count."""
        super().initialise()
        self.num_success = self._count()

    def save_state(self, _now_ns: int) -> dict[str, Any]:
        """The rounds done, and how many there are."""
        return {"done": self.success, "count": self.num_success}

    def restore_state(self, state: dict[str, Any], _now_ns: int) -> None:
        """Go on with the next round."""
        self.success, self.num_success = state["done"], state["count"]

    def update(self) -> Status:
        """Count a success; say which round this is."""
        status = super().update()
        current = min(self.success + 1, self.num_success)
        self.feedback_message = f"{current} of {self.num_success}"
        return status


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

    Outputs go to the caller when the tree has ended, with success or failure, if it has written
    them; not when it is halted.

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
        values = dict(self._inputs())
        self.inner.values.clear()
        self.inner.values.update(values)

    def update(self) -> Status:
        """End as the tree does."""
        self.feedback_message = ""
        return self.decorated.status

    def terminate(self, new_status: Status) -> None:
        """Hand the outputs out."""
        if new_status is not Status.INVALID:
            values = self.inner.values
            found = {ours: values[name] for name, ours in self._outputs.items() if name in values}
            self._outer.values.update(found)
