"""The leaves that publish a message, once somebody listens, and that wait for one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from py_trees.common import Status

from bt_mission.behaviours.evaluator import Evaluator, MessageFields, values_read
from bt_mission.behaviours.leaves import ClientLeaf
from bt_mission.behaviours.runtime import LatestMessage, MissionFailure, Publisher
from bt_mission.core.stamps import NS
from bt_mission.language.nodes.interfaces import PublishNode, WaitForNode


class PublishLeaf(ClientLeaf):
    """Publishes a message each time it starts, as soon as so many subscriptions are matched.

    It fails when they are not there in time.
    """

    _client: Publisher

    def __init__(self, node: PublishNode, values: Evaluator) -> None:
        super().__init__(node, values)
        self._message: Any = None
        self._until_ns = 0

    def _connected(self, name: str, type_name: str) -> Publisher:
        return self._runtime.publisher(name, type_name)

    def initialise(self) -> None:
        """Make the message.

        Raises:
            MissionFailure: When a value does not fit its field.
        """
        with self._values.starting():
            self._message = self._client.prepare(self._values.resolve(self._node.sent))
        self._until_ns = self._runtime.now_ns + round(self._node.server_timeout * NS)

    def update(self) -> Status:
        """Publish it once it is heard."""
        there = self._client.count_readers()
        if there >= self._node.readers:
            self._client.publish(self._message)
            self.feedback_message = f"published to {there}" if there else "published to nobody"
            return Status.SUCCESS
        wanted = "nobody listens" if there == 0 else f"{there} of {self._node.readers} listen"
        self.feedback_message = f"{wanted} to {self._client.name}"
        if self._runtime.now_ns < self._until_ns:
            return Status.RUNNING
        self.feedback_message += f" after {self._node.server_timeout:g} s"
        return Status.FAILURE


class WaitFor(ClientLeaf):
    """Succeeds at the first tick after a message has met the condition; latches until then.

    Messages count from the moment the leaf is reached. A topic that is latched tells its newest
    message at once.
    """

    _client: LatestMessage

    def __init__(self, node: WaitForNode, values: Evaluator) -> None:
        super().__init__(node, values)
        self._timeout_s: float | None = None
        self._condition: Callable[[Any], str | None]
        self._since_ns = 0
        self._newest: Any = None
        self._met: tuple[str, Any] | None = None
        self._error: MissionFailure | None = None

    def _connected(self, name: str, type_name: str) -> LatestMessage:
        return self._runtime.subscriber(name, type_name)

    def initialise(self) -> None:
        """Begin to listen."""
        self._timeout_s = self._values.limit(self._node.timeout)
        self._condition = self._values.condition("until", self._node.condition)
        self._since_ns = self._runtime.now_ns
        self._newest = self._met = self._error = None
        self._client.listen(self._hear)

    def update(self) -> Status:
        """Look at what was heard, and at the limit; what comes with the deadline wins."""
        self._client.look_around()
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
        self._client.leave(self._hear)
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
        name = self._client.name
        if self._newest is None:
            return f"{name}: no message within {limit_s:g} s; {self._client.why_silent()}"
        text = self._node.condition.text
        return f"{name}: '{text}' was not met within {limit_s:g} s (last: {self._last()})"
