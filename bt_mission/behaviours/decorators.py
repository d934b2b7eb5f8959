"""Repeat and retry, as py_trees' own, with counts and pauses known only when they start."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.behaviours.hooks import HookedDecorator
from bt_mission.behaviours.runtime import NS, Runtime


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
