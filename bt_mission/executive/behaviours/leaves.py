"""The base of our leaves, and the leaves without a server."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.base.stamps import NS
from bt_mission.executive.behaviours.evaluator import Evaluator, brief
from bt_mission.executive.behaviours.hooks import Hooked
from bt_mission.executive.behaviours.runtime import Runtime
from bt_mission.language.nodes.fields import SECONDS

RUNNING = Status.RUNNING


@dataclass(frozen=True)
class LeafProgress:
    """The progress of a running leaf towards something that ends it.

    Args:
        label: The measure: a field of the feedback, or ``s`` for the leaf's time.
    """

    label: str
    value: float
    limit: float


def progress_of(node: Behaviour) -> LeafProgress | None:
    """Return the ``progress`` of a running node, if it has one."""
    if node.status is not Status.RUNNING:
        return None
    progress = getattr(node, "progress", None)
    return progress if isinstance(progress, LeafProgress) else None


class Leaf(Hooked):
    """A leaf that ticks and stops as in py_trees, several times faster.

    At each tick and each stop py_trees formats a line for its log, even if it is disabled, and
    checks whether the new status is in the list of statuses. The type checker verifies what our
    leaves return. Leaves of users keep py_trees' methods.
    """

    _runtime: Runtime

    def __init__(self, node: Any, values: Evaluator) -> None:
        super().__init__(node.label)
        self._values = values

    def setup(self, **kwargs: Any) -> None:
        """Take the runtime."""
        self._runtime = kwargs["runtime"]

    def tick(self) -> Iterator[Behaviour]:
        """Initialise unless it is running; update; stop if it has ended."""
        if self.status is not RUNNING:
            # Not by `walk` and a second call: most of what is ticked are leaves.
            if self.start_hook is not None:
                yield from self.start_hook(self)
            if self.call_hooks:
                self.run_call_hooks("initialise")
            self.initialise()
        given = self.run_call_hooks("update") if self.call_hooks else None
        status = self.update() if given is None else given
        if status is not RUNNING:
            self.stop(status)
        self.status = status
        yield self

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """End with this status."""
        if new_status is Status.INVALID:
            self.note_reset(new_status)
        if self.call_hooks:
            self.run_call_hooks("terminate")
        self.terminate(new_status)
        self.status = new_status

    def call_terminate(self, new_status: Status) -> None:
        """Terminate without a change of status."""
        self.run_call_hooks("terminate")
        self.terminate(new_status)


class Wait(Leaf):
    """Runs for a time of the ROS clock, then succeeds."""

    _wait_s = 0.0
    due_ns = 0
    """The instant at which it ends."""

    def initialise(self) -> None:
        """Fix the end."""
        self._wait_s = self._values.number(self._node.seconds, SECONDS)
        self.due_ns = self._runtime.now_ns + round(self._wait_s * NS)

    def save_state(self, now_ns: int) -> dict[str, Any]:
        """Return the remaining time of the wait."""
        return {"left_ns": self.due_ns - now_ns}

    def restore_state(self, state: dict[str, Any], now_ns: int) -> None:
        """Wait for the remaining time."""
        self.due_ns = now_ns + state["left_ns"]

    def update(self) -> Status:
        """Look at the ROS clock."""
        left_s = self._left_s
        self.feedback_message = f"{max(left_s, 0):.1f} s left"
        return Status.SUCCESS if left_s <= 0 else Status.RUNNING

    @property
    def progress(self) -> LeafProgress:
        """Towards its end."""
        return LeafProgress("s", self._wait_s - self._left_s, self._wait_s)

    @property
    def _left_s(self) -> float:
        return (self.due_ns - self._runtime.now_ns) / NS


MOST_LOGGED = 1_000
"""Characters of a log line; a list of pictures in it would flood the terminal."""


class Log(Leaf):
    """Logs a line for viewers, and succeeds."""

    def update(self) -> Status:
        """Log the line, cut after `MOST_LOGGED` characters."""
        line = str(self._values.resolve(self._node.message))
        if len(line) > MOST_LOGGED:
            line = f"{line[:MOST_LOGGED]} ... ({len(line):,} characters)"
        self.feedback_message = line
        self._runtime.log(self.feedback_message)
        return Status.SUCCESS


class Check(Leaf):
    """Succeeds where a condition holds, else fails."""

    def update(self) -> Status:
        """Evaluate the condition once."""
        result = self._values.ask(self._node.condition)
        self.feedback_message = result.text
        return Status.SUCCESS if result.holds else Status.FAILURE


class Set(Leaf):
    """Sets variables to new values in order, and succeeds."""

    def update(self) -> Status:
        """Compute and assign them."""
        variables, written = self._values.scope.values, self._node.values
        for name, value in written.items():
            variables[name] = self._values.resolve(value)
        self.feedback_message = ", ".join(f"{name} = {brief(variables[name])}" for name in written)
        return Status.SUCCESS
