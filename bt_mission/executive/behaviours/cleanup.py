"""A node with a clean-up that runs in any case: after its end, a halt, or the mission's end."""

from __future__ import annotations

from collections.abc import Iterator
from enum import StrEnum
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Composite

from bt_mission.base.errors import cause_of
from bt_mission.base.stamps import NS
from bt_mission.executive.behaviours.evaluator import Evaluator
from bt_mission.executive.behaviours.hooks import Hooked
from bt_mission.executive.behaviours.runtime import Runtime
from bt_mission.language.nodes.composites import FinallyNode
from bt_mission.language.nodes.fields import LIMIT


class CleanUpPhase(StrEnum):
    """The progress of a node with a clean-up."""

    IDLE = "idle"
    BODY = "body"
    CLEANUP = "cleanup"
    DETACHED = "detached"
    """The node was halted: the caller of the tree's tick also ticks its clean-up until that has
    ended.
    """


class Finally(Hooked, Composite):
    """Runs a node, then its clean-up, and ends as the node does; fails if the clean-up fails.

    If it is halted in between, :meth:`tick_detached` runs the clean-up, with the variables as they
    were, so that the tree cannot change it meanwhile. The node starts again only after that.
    """

    def __init__(self, node: FinallyNode, values: Evaluator) -> None:
        super().__init__(node.label, values.children)
        self.body, self.cleanup = values.children
        self.failure = ""
        """Why the last clean-up after a halt failed; empty if it succeeded."""
        self._values, self._scope = values, values.scope
        self._stage = CleanUpPhase.IDLE
        self._limit_s = 0.0
        self._until_ns = 0
        self._result = Status.FAILURE
        self._variables: dict[str, Any] = {}
        self._inner: list[Finally] = []
        self._runtime: Runtime

    def setup(self, **kwargs: Any) -> None:
        """Take the runtime."""
        self._runtime = kwargs["runtime"]
        self._inner = [node for node in self.body.iterate() if isinstance(node, Finally)]

    def read_again(self) -> None:
        """Take the limit of a new version of the node."""
        self._limit_s = self._values.number(self._node.settings.timeout, LIMIT)

    @property
    def is_detached(self) -> bool:
        """Whether its clean-up is under way after a halt."""
        return self._stage is CleanUpPhase.DETACHED

    @property
    def limit_s(self) -> float:
        """The limit of the clean-up that is due, s; 0 without one."""
        return 0.0 if self._stage is CleanUpPhase.IDLE else self._limit_s

    @property
    def due_ns(self) -> int | None:
        """The instant at which the clean-up has no time left; None unless it is under way."""
        is_cleaning = self._stage in (CleanUpPhase.CLEANUP, CleanUpPhase.DETACHED)
        return self._until_ns if is_cleaning else None

    def why_over(self) -> str:
        """Why the clean-up has no time left; empty if it has, or has not begun."""
        is_cleaning = self._stage in (CleanUpPhase.CLEANUP, CleanUpPhase.DETACHED)
        return self._too_late if is_cleaning and self._runtime.now_ns >= self._until_ns else ""

    @property
    def _too_late(self) -> str:
        return f"clean-up not done within {self._limit_s:g} s"

    # ---- in the tree ---------------------------------------------------------------------

    def walk(self) -> Iterator[Behaviour]:
        """Tick the node, and the clean-up from the tick on in which the node ends."""
        if self._stage is CleanUpPhase.DETACHED:
            self.feedback_message = "waits for its last clean-up"
            self.status = Status.RUNNING
            yield self
            return
        if self._stage is CleanUpPhase.IDLE:
            self._limit_s = self._values.number(self._node.settings.timeout, LIMIT)
            self.cleanup.stop(Status.INVALID)
            self._stage, self.feedback_message = CleanUpPhase.BODY, ""
        if self._stage is CleanUpPhase.BODY:
            self.current_child = self.body
            yield from self.body.tick()
            self._variables = self._scope.written()
            if self.body.status is Status.RUNNING:
                self.status = Status.RUNNING
                yield self
                return
            self._result = self.body.status
            self._begin_cleanup(CleanUpPhase.CLEANUP)
        self.current_child = self.cleanup
        try:
            yield from self.cleanup.tick()
        except Exception:
            self._stage = CleanUpPhase.IDLE  # it ends the mission, and is not begun again
            raise
        why = self._why_ended()
        if why is None:
            self.status = Status.RUNNING
        else:
            self.feedback_message = why
            self._stage = CleanUpPhase.IDLE
            if self.cleanup.status is Status.RUNNING:
                self.cleanup.stop(Status.INVALID)
            self.stop(Status.FAILURE if why else self._result)
        yield self

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """End. A halted node continues with its clean-up."""
        self.note_reset(new_status)
        if self.body.status is not Status.INVALID and new_status is Status.INVALID:
            self.body.stop(Status.INVALID)
        if self._stage is CleanUpPhase.BODY:
            self._begin_cleanup(CleanUpPhase.DETACHED)
        elif self._stage is CleanUpPhase.CLEANUP:
            self._stage, self._runtime.ledger.is_held = CleanUpPhase.DETACHED, True
        elif self._stage is CleanUpPhase.IDLE and new_status is Status.INVALID:
            self.cleanup.stop(Status.INVALID)
        self.status = new_status
        if new_status is Status.INVALID:
            self.current_child = None

    def _begin_cleanup(self, stage: CleanUpPhase) -> None:
        self._stage, self.failure = stage, ""
        self._runtime.ledger.is_held |= stage is CleanUpPhase.DETACHED
        self._until_ns = self._runtime.now_ns + round(self._limit_s * NS)

    def _why_ended(self) -> str | None:
        """Return why the clean-up failed, empty if it succeeded; None while it runs."""
        status = self.cleanup.status
        if status is Status.SUCCESS:
            return ""
        if status is Status.FAILURE:
            tip = self.cleanup.tip() or self.cleanup
            return f"clean-up failed: '{tip.name}' {tip.feedback_message or 'failed'}"
        left_s = (self._until_ns - self._runtime.now_ns) / NS
        if left_s <= 0:
            return self._too_late
        self.feedback_message = f"cleaning up, {left_s:.1f} s left"
        return None

    # ---- behind a halt -------------------------------------------------------------------

    def tick_detached(self) -> Iterator[Behaviour]:
        """Tick a clean-up after a halt. An exception in it ends only the clean-up.

        Clean-ups of deeper nodes run first.
        """
        if any(node.is_detached for node in self._inner):
            self._until_ns = self._runtime.now_ns + round(self._limit_s * NS)
            return
        around = self._scope.written()
        self._scope.replace(self._variables)
        visited: list[Behaviour] = []
        try:
            visited += self.cleanup.tick()
            why = self._why_ended()
        except Exception as error:  # noqa: BLE001 - a user's leaf may raise anything
            why = f"clean-up failed: {cause_of(error)}"
        finally:
            self._variables = self._scope.written()
            self._scope.replace(around)
        if why is not None:
            self._end_detached(why)
        yield from visited

    def skip(self, reason: str) -> None:
        """End a clean-up behind a halt before its end."""
        self._end_detached(f"clean-up skipped: {reason}")

    def _end_detached(self, why: str) -> None:
        self.failure = self.feedback_message = why
        self._stage = CleanUpPhase.IDLE
        if why:
            self._runtime.log(f"'{self.name}': {why}")
        if self.cleanup.status is Status.RUNNING:
            self.cleanup.stop(Status.INVALID)
        if self.status is Status.RUNNING:  # it was entered again, and waits
            self.status = Status.INVALID

    # ---- for the journal -----------------------------------------------------------------

    def save_state(self, now_ns: int) -> dict[str, Any]:
        """Return its phase, the node's status, and the clean-up's remaining time."""
        return {
            "stage": self._stage.value,
            "result": self._result.value,
            "limit_s": self._limit_s,
            "left_ns": self._until_ns - now_ns,
            "values": [list(variable) for variable in self._variables.items()],
        }

    def restore_state(self, state: dict[str, Any], now_ns: int) -> None:
        """Continue with the node, or with the clean-up."""
        self._stage, self._result = CleanUpPhase(state["stage"]), Status(state["result"])
        self._limit_s, self._until_ns = state["limit_s"], now_ns + state["left_ns"]
        self._variables = dict(state["values"])
