"""The leaf that calls a service once and waits for the answer, without ever blocking a tick."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from py_trees.common import Status

from bt_mission.behaviours.evaluator import Evaluator
from bt_mission.behaviours.leaves import ClientLeaf
from bt_mission.behaviours.runtime import ServiceClient
from bt_mission.core.stamps import NS
from bt_mission.language.nodes.fields import LIMIT
from bt_mission.language.nodes.interfaces import ServiceNode


class ServiceLeaf(ClientLeaf):
    """Calls a service each time it starts; the answer makes it succeed.

    It fails when there is no server or no answer in time, and when the response has a field
    ``success`` that is false. Outputs are written from every response. An answer that comes
    after the leaf has ended, or was halted, changes nothing.
    """

    _client: ServiceClient

    def __init__(self, node: ServiceNode, values: Evaluator) -> None:
        super().__init__(node, values)
        self._answer_s = 0.0
        self._request: Any = None
        self._since_ns = 0
        self._answers: list[Any] = []
        self._forget: Callable[[], None] | None = None

    def _connected(self, name: str, type_name: str) -> ServiceClient:
        return self._runtime.service_client(name, type_name)

    def initialise(self) -> None:
        """Begin anew; nothing that was called before is heard any more.

        Raises:
            MissionFailure: When the request's values do not fit its type.
        """
        with self._values.starting():
            self._request = self._client.prepare(self._values.resolve(self._node.sent))
        self._answer_s = self._values.number(self._node.timeout, LIMIT)
        self._answers, self._forget = [], None
        self._since_ns = self._runtime.now_ns

    def update(self) -> Status:
        """Call as soon as there is a server; then look for the answer, and at the limits."""
        waited_s = (self._runtime.now_ns - self._since_ns) / NS
        if self._forget is None:
            if self._client.is_ready():
                self._since_ns = self._runtime.now_ns
                self._forget = self._client.call(self._request, self._answers.append)
                return self._running("waiting for the answer")
            if waited_s >= self._node.server_timeout:
                return self._fail(f"no server after {self._node.server_timeout:g} s")
            return self._running("waiting for the server")
        if self._answers:
            return self._read(self._answers[0])
        if waited_s >= self._answer_s:
            return self._fail(f"no answer within {self._answer_s:g} s")
        return self._running("waiting for the answer")

    def terminate(self, new_status: Status) -> None:
        """Forget a call that has not been answered."""
        if self._forget is not None and not self._answers:
            self._forget()
            self._forget = None
        if new_status is Status.INVALID and self.status is Status.RUNNING:
            self.feedback_message = "halted"

    def _read(self, response: Any) -> Status:
        self._values.store(self._node.outputs, response)
        message = getattr(response, "message", "")
        said = message if isinstance(message, str) else ""
        if getattr(response, "success", True) is False:
            return self._fail(f"answered no success{f': {said}' if said else ''}")
        self.feedback_message = said
        return Status.SUCCESS

    def _running(self, message: str) -> Status:
        self.feedback_message = message
        return Status.RUNNING

    def _fail(self, message: str) -> Status:
        self.feedback_message = f"{self._client.name}: {message}"
        return Status.FAILURE
