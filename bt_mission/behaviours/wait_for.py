"""The leaf that waits until a message of a topic meets a condition."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from py_trees.common import Status

from bt_mission.behaviours.evaluator import Evaluator, MessageFields, values_read
from bt_mission.behaviours.leaves import Leaf
from bt_mission.behaviours.runtime import LatestMessage, MissionFailure, Runtime, placed
from bt_mission.core.stamps import NS
from bt_mission.language.nodes.interfaces import WaitForNode


class WaitFor(Leaf):
    """Succeeds at the first tick after a message has met the condition; latches until then.

    Messages count from the moment the leaf is reached. A topic that is latched tells its newest
    message at once.
    """

    def __init__(self, node: WaitForNode, values: Evaluator) -> None:
        super().__init__(node.label)
        self._node = node
        self._values = values
        self._timeout_s: float | None = None
        self._condition: Callable[[Any], str | None]
        self._since_ns = 0
        self._newest: Any = None
        self._met: tuple[str, Any] | None = None
        self._error: MissionFailure | None = None
        self._runtime: Runtime
        self._subscriber: LatestMessage

    def setup(self, **kwargs: Any) -> None:
        """Take the runtime and subscribe."""
        self._runtime = kwargs["runtime"]
        with placed(self._values.place):
            self._subscriber = self._runtime.subscriber(self._node.ros_name, self._node.type)

    def initialise(self) -> None:
        """Begin to listen."""
        self._timeout_s = self._values.limit(self._node.timeout)
        self._condition = self._values.condition("until", self._node.condition)
        self._since_ns = self._runtime.now_ns
        self._newest = self._met = self._error = None
        self._subscriber.listen(self._hear)

    def update(self) -> Status:
        """Look at what was heard, and at the limit; what comes with the deadline wins."""
        self._subscriber.look_around()
        if self._error is not None:
            raise self._error
        if self._met is not None:
            self.feedback_message, message = self._met
            self._values.store(self._node.outputs, message)
            return Status.SUCCESS
        limit_s = self._timeout_s
        if limit_s is not None and self._runtime.now_ns - self._since_ns >= limit_s * NS:
            self.feedback_message = self._in_vain(limit_s)
            return Status.FAILURE
        self.feedback_message = self._last() or "no message yet"
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Listen no more."""
        self._subscriber.leave(self._hear)
        if new_status is Status.INVALID and self.status is Status.RUNNING:
            self.feedback_message = "halted"

    def _hear(self, message: Any) -> None:
        """Ask the condition; errors in it are kept for the next tick."""
        if self._met is not None or self._error is not None:
            return
        self._newest = message
        try:
            met = self._condition(message)
        except MissionFailure as error:
            self._error = error
            return
        if met is not None:
            self._met = met, message

    def _last(self) -> str:
        if self._newest is None:
            return ""
        return values_read(self._node.condition, MessageFields(self._newest))

    def _in_vain(self, limit_s: float) -> str:
        name = self._subscriber.name
        if self._newest is None:
            return f"{name}: no message within {limit_s:g} s; {self._subscriber.why_silent()}"
        text = self._node.condition.text
        return f"{name}: '{text}' was not met within {limit_s:g} s (last: {self._last()})"
