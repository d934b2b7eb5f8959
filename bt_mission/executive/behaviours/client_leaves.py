"""The leaves that call a service, publish a message or wait for one; a tick never blocks."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable
from typing import Any

from py_trees.common import Status

from bt_mission.base.stamps import NS
from bt_mission.executive.behaviours.evaluator import Evaluator, MessageFields, values_read
from bt_mission.executive.behaviours.leaves import Leaf
from bt_mission.executive.behaviours.runtime import (
    LatestMessage,
    MissionFailure,
    Publisher,
    ServiceClient,
    placed,
)
from bt_mission.language.nodes.fields import LIMIT


class ClientLeaf(Leaf):
    """A leaf of a node that names an action, a service or a topic."""

    _client: Any

    def setup(self, **kwargs: Any) -> None:
        """Take the runtime, and make the client."""
        super().setup(**kwargs)
        with placed(self._values.place):
            self._client = self._connected(self._node.ros_name, self._node.type)

    @abstractmethod
    def _connected(self, name: str, type_name: str) -> Any:
        """Return the client of a name and type."""


class ServiceLeaf(ClientLeaf):
    """Calls a service each time it starts, and succeeds with the response.

    It fails without a server or a response in time, and if the response has a field ``success``
    that is false. Outputs are written from every response. A response that arrives after the leaf
    has ended, or was halted, has no effect.
    """

    _client: ServiceClient
    answer_s: float
    """The limit of the wait for an answer, as it was computed at entry, s."""
    _request: Any
    _since_ns: int
    _forget: Callable[[], None] | None = None

    def __init__(self, node: Any, values: Evaluator) -> None:
        super().__init__(node, values)
        self.answers: list[Any] = []
        """The responses to its newest call."""

    def _connected(self, name: str, type_name: str) -> ServiceClient:
        return self._runtime.service_client(name, type_name)

    def initialise(self) -> None:
        """Start again; the response to an earlier call is ignored.

        Raises:
            MissionFailure: The request's values do not fit its type.
        """
        with self._values.starting():
            self._request = self._client.prepare(self._values.resolve(self._node.sent))
        self.answer_s = self._values.number(self._node.timeout, LIMIT)
        self.answers, self._forget = [], None
        self._since_ns = self._runtime.now_ns

    @property
    def due_ns(self) -> int | None:
        """The instant at which a wait for the server, or for its answer, is over; else None."""
        if self._forget is not None and self.answers:
            return None
        limit_s = self._node.server_timeout if self._forget is None else self.answer_s
        return self._since_ns + math.ceil(limit_s * NS)

    def update(self) -> Status:
        """Call as soon as there is a server; then check the response and the limits."""
        waited_s = (self._runtime.now_ns - self._since_ns) / NS
        if self._forget is None:
            if self._client.is_ready():
                self._since_ns = self._runtime.now_ns
                self._forget = self._client.call(self._request, self.answers.append)
                return self._running("waiting for the answer")
            if waited_s >= self._node.server_timeout:
                return self._fail(f"no server after {self._node.server_timeout:g} s")
            return self._running("waiting for the server")
        if self.answers:
            return self._read(self.answers[0])
        if waited_s >= self.answer_s:
            return self._fail(f"no answer within {self.answer_s:g} s")
        return self._running("waiting for the answer")

    def terminate(self, new_status: Status) -> None:
        """Drop a call that is not answered."""
        if self._forget is not None and not self.answers:
            self._forget()
            self._forget = None
        if new_status is Status.INVALID and self.status is Status.RUNNING:
            self.feedback_message = "halted"

    def _read(self, response: Any) -> Status:
        self._values.store(self._node.outputs, response)
        message = getattr(response, "message", "")
        text = message if isinstance(message, str) else ""
        if getattr(response, "success", True) is False:
            return self._fail(f"answered no success{f': {text}' if text else ''}")
        self.feedback_message = text
        return Status.SUCCESS

    def _running(self, message: str) -> Status:
        self.feedback_message = message
        return Status.RUNNING

    def _fail(self, message: str) -> Status:
        self.feedback_message = f"{self._client.name}: {message}"
        return Status.FAILURE


class PublishLeaf(ClientLeaf):
    """Publishes a message each time it starts, as soon as enough subscriptions are matched.

    It fails if they are not matched in time.
    """

    _client: Publisher
    _message: Any
    _until_ns: int

    def _connected(self, name: str, type_name: str) -> Publisher:
        return self._runtime.publisher(name, type_name)

    def initialise(self) -> None:
        """Make the message.

        Raises:
            MissionFailure: A value does not fit its field.
        """
        with self._values.starting():
            self._message = self._client.prepare(self._values.resolve(self._node.sent))
        self._until_ns = self._runtime.now_ns + round(self._node.server_timeout * NS)

    @property
    def due_ns(self) -> int:
        """The instant at which the wait for subscriptions is over."""
        return self._until_ns

    def update(self) -> Status:
        """Publish the message once the subscriptions are matched."""
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

    Messages count from the start of the leaf. A latched topic sends its newest message at once.
    """

    _client: LatestMessage
    _timeout_s: float | None
    _condition: Callable[[Any], str | None]
    _since_ns: int
    _newest: Any
    _met: tuple[str, Any] | None
    _error: MissionFailure | None

    def _connected(self, name: str, type_name: str) -> LatestMessage:
        return self._runtime.subscriber(name, type_name)

    def initialise(self) -> None:
        """Begin to listen."""
        self._timeout_s = self._values.limit(self._node.timeout)
        self._condition = self._values.condition("until", self._node.condition)
        self._since_ns = self._runtime.now_ns
        self._newest = self._met = self._error = None
        self._client.listen(self._hear)

    @property
    def due_ns(self) -> int | None:
        """The instant of its limit; None without one, and once a message has met the condition."""
        limit_s = self._timeout_s if self._met is None else None
        return None if limit_s is None else self._since_ns + math.ceil(limit_s * NS)

    def update(self) -> Status:
        """Check the received messages and the limit.

        A message that arrives with the deadline wins.
        """
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
        """Evaluate the condition. Its errors are kept for the next tick."""
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
